//! Why a mediator cannot go on from its journal, and why an operator's request is refused.

use coordination::protocol::MergeError;

use crate::setup::SetupError;

/// Why a mediator cannot go on from its journal.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[expect(missing_docs, reason = "the messages say what each field is")]
pub enum RestoreError {
    /// The site's own areas and robots.
    #[error(transparent)]
    Setup(#[from] SetupError),
    /// The journal is of another site, or that site has changed.
    #[error(
        "the journal knows {kind} `{id}`, which the site does not have: use the journal's own site file, or begin a new journal when every robot stands still"
    )]
    Unknown {
        /// Area or robot.
        kind: &'static str,
        id: String,
    },
    /// A stored level that the protocol does not have.
    #[error(
        "journal: the level of robot `{robot}` in area `{area}` does not exist in protocol `{protocol}`: {error}"
    )]
    Level {
        robot: String,
        area: String,
        /// Access or revocation.
        protocol: &'static str,
        error: MergeError,
    },
}

/// Why an area was not cleared.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[expect(missing_docs, reason = "the messages say what each field is")]
pub enum ClearError {
    /// No such area.
    #[error("there is no area `{found}`; this site has {known}")]
    UnknownArea { found: String, known: String },
    /// Somebody is in it.
    #[error("area `{area}` is not cleared: robot `{robot}` is in it and is heard")]
    Heard { area: String, robot: String },
}

/// Why a robot does not count as absent.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum AbsentError {
    /// No such robot.
    #[error(transparent)]
    Unknown(#[from] UnknownRobot),
    /// It reports.
    #[error(
        "robot `{0}` is heard, so it is somewhere: switch it off, or see that it follows this mediator"
    )]
    Heard(String),
}

/// No such robot.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("there is no robot `{found}`; this site has {known}")]
#[expect(missing_docs, reason = "the message says what each field is")]
pub struct UnknownRobot {
    pub found: String,
    pub known: String,
}
