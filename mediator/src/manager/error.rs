//! Why a mediator cannot go on from its journal, and why an operator's request is refused.

use std::time::Duration;

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
        "the journal knows {kind} `{id}`, which the site does not have: use the journal's own site file (a robot leaves it when it was said to be absent), or begin a new journal when every robot stands still"
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
    /// Robots follow no mediator whose journal has the number 0.
    #[error(
        "the journal has the number 0, with which robots follow no mediator: begin a new journal when every robot stands still"
    )]
    Nameless,
}

/// It has this time to open a link.
const AFTER_START: &str =
    "after a start of the mediator a second process that was found counts as heard for 5 s";

/// Why an area was not cleared.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[expect(missing_docs, reason = "the messages say what each field is")]
pub enum ClearError {
    /// No such area.
    #[error(transparent)]
    Unknown(#[from] UnknownArea),
    /// Somebody is in it.
    #[error(
        "area `{area}` is not cleared: robot `{robot}` or a second process of it is in it and is heard; {AFTER_START}"
    )]
    Heard { area: String, robot: String },
    /// It was granted it, and may live behind a broken link.
    #[error(
        "area `{area}` is not cleared: robot `{robot}`, to which it was granted, may still enter it for {} s; wait, see whether it is there, and say it again",
        seconds(*.wait)
    )]
    MayEnter {
        area: String,
        robot: String,
        wait: Duration,
    },
    /// It stands there, for all that is known.
    #[error(
        "area `{area}` is not cleared: robot `{robot}` stands in it, for all that is known; look, and if it was taken away, say so: `mediator clear {area} --taken-away`"
    )]
    Inside { area: String, robot: String },
    /// Another mediator goes on, and knows.
    #[error(transparent)]
    StandsBy(#[from] StandsBy),
}

/// Why an area was not closed, or not opened.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum CloseError {
    /// No such area.
    #[error(transparent)]
    Unknown(#[from] UnknownArea),
    /// Another mediator lets robots in.
    #[error(transparent)]
    StandsBy(#[from] StandsBy),
}

/// Why a coordination was not ended.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum EndError {
    /// No such coordination runs.
    #[error(transparent)]
    NotRunning(#[from] NotRunning),
    /// Another mediator orders.
    #[error(transparent)]
    StandsBy(#[from] StandsBy),
}

/// An operator's order is carried out by nobody: robots follow another mediator.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("this mediator stands by: say it to the one that robots follow")]
pub struct StandsBy;

/// No such coordination runs.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("no coordination `{found}` runs; {}", if running.is_empty() { "none does".to_owned() } else { format!("there are {}", running.join(", ")) })]
#[expect(missing_docs, reason = "the message says what each field is")]
pub struct NotRunning {
    pub found: String,
    pub running: Vec<String>,
}

/// Why a robot does not count as absent.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum AbsentError {
    /// No such robot.
    #[error(transparent)]
    Unknown(#[from] UnknownRobot),
    /// It reports.
    #[error(
        "robot `{0}` or a second process of it is heard, so it is somewhere: switch it off, or see that it follows this mediator; {AFTER_START}"
    )]
    Heard(String),
    /// It was granted something, and may live behind a broken link.
    #[error(
        "robot `{robot}` may still enter for {} s what it was granted: wait, look where it is, and say it again",
        seconds(*.wait)
    )]
    MayEnter {
        /// Which one.
        robot: String,
        /// For how long.
        wait: Duration,
    },
    /// It stands in some, for all that is known.
    #[error(
        "robot `{robot}` stands in {areas}, for all that is known; look, and if it was taken away, say so: `mediator absent {robot} --taken-away`"
    )]
    Inside {
        /// Which one.
        robot: String,
        /// Where.
        areas: String,
    },
    /// Another mediator goes on, and knows.
    #[error(transparent)]
    StandsBy(#[from] StandsBy),
}

/// To the next tenth, so that it is over when they are.
fn seconds(wait: Duration) -> f64 {
    (wait.as_secs_f64() * 10.0).ceil() / 10.0
}

/// No such area.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("there is no area `{found}`; this site has {known}")]
#[expect(missing_docs, reason = "the message says what each field is")]
pub struct UnknownArea {
    pub found: String,
    pub known: String,
}

/// No such robot.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("there is no robot `{found}`; this site has {known}")]
#[expect(missing_docs, reason = "the message says what each field is")]
pub struct UnknownRobot {
    pub found: String,
    pub known: String,
}
