//! What a running robot says to a request.

use std::fmt;

use description::geometry::Pose2;
use skills::navigator::{Hold, InstructionError};

use crate::symbols::faults::Fault;

/// What was done, or why nothing was.
pub type Reply = Result<Done, Refusal>;

/// What was done.
#[derive(Clone, Debug, PartialEq)]
pub enum Done {
    /// The robot slows down and stands.
    Paused,
    /// It goes on.
    Running,
    /// It stops hard.
    Stopped,
    /// Faults that wait for an operator are forgotten, and none has come back. These others last.
    Reset(Vec<Fault>),
    /// It has taken the operator's word for where it stands, and looked at walls since.
    Placed(Placement),
    /// It takes the operator's word for the floor behind it, so many metres.
    FreeBehind(f64),
    /// It says that it carries this, or nothing.
    Carries(Option<String>),
    /// The files were read again.
    Reloaded,
    /// It is in the hands of who asked, by a session of this number.
    Lent(u64),
    /// The machine took an event.
    Sent {
        /// The event.
        event: String,
        /// The state that the machine was in.
        from: String,
        /// The state that it is in now.
        to: String,
        /// Why the robot does not move in it, if it does not.
        hold: Option<Hold>,
    },
}

impl fmt::Display for Done {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Paused => f.write_str("paused"),
            Self::Running => f.write_str("running"),
            Self::Stopped => f.write_str("stopped; `onboard ctl reset` goes on"),
            Self::Reset(lasting) if lasting.is_empty() => f.write_str("reset"),
            Self::Reset(lasting) => {
                f.write_str("reset; what else is the matter:")?;
                { lasting.iter() }
                    .try_for_each(|fault| write!(f, "\n  {}: {}", fault.name(), fault.sentence()))
            }
            Self::Placed(placement) => write!(f, "{placement}"),
            Self::FreeBehind(way_m) => {
                write!(f, "the floor behind it counts as free for {way_m} m")
            }
            Self::Carries(Some(name)) => write!(f, "it carries {name}"),
            Self::Carries(None) => f.write_str("it carries nothing"),
            Self::Reloaded => f.write_str("reloaded"),
            Self::Lent(session) => write!(f, "in your hands, session {session}"),
            Self::Sent {
                event,
                from,
                to,
                hold,
            } => {
                write!(f, "`{event}`: state {from} -> {to}")?;
                match hold {
                    Some(hold) => write!(f, "; the robot stands: {}", hold.reason()),
                    None => Ok(()),
                }
            }
        }
    }
}

/// Where the robot believes to stand, a second after an operator has told it, and what walls say.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Placement {
    /// `base_link` in `map`.
    pub pose: Pose2,
    /// Walls that its newest scan shows where the pose has them,
    pub agree: u64,
    /// and walls that it shows elsewhere or looks through.
    pub contradict: u64,
    /// It has looked at a scan since.
    pub looked: bool,
    /// That shows none of the walls that should be in view.
    pub unseen: bool,
}

impl fmt::Display for Placement {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Pose2 {
            x_m,
            y_m,
            theta_rad,
        } = self.pose;
        write!(
            f,
            "placed: it believes to be at {x_m:.3} m, {y_m:.3} m, {theta_rad:.3} rad; "
        )?;
        let walls = |count: u64| if count == 1 { "wall" } else { "walls" };
        let (agree, contradict) = (self.agree, self.contradict);
        match (self.looked, agree, contradict) {
            (false, ..) => {
                f.write_str("it has not looked at a scan since, so nothing confirms that")
            }
            (true, 0, 0) if self.unseen => f.write_str(
                "none of the walls that should be in view is where it should be, which contradicts that: look where it stands, and say so again",
            ),
            (true, 0, 0) => f.write_str("no wall in view confirms that"),
            (true, _, 0) => write!(f, "{agree} {} agree", walls(agree)),
            (true, ..) => write!(
                f,
                "{contradict} {} contradict, {agree} agree: look where it stands, and say so again",
                walls(contradict)
            ),
        }
    }
}

/// Why nothing was done.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[expect(missing_docs, reason = "the messages say what each field is")]
pub enum Refusal {
    /// Who asks is another user.
    #[error("{0}")]
    Stranger(String),
    /// The line is none of the requests.
    #[error("unknown request {0:?}")]
    UnknownRequest(String),
    /// The event is not the JSON of one.
    #[error("the event cannot be read: {0}")]
    Unreadable(String),
    /// `resume` of a robot that a fault has stopped.
    #[error("it is stopped by a fault; see `onboard inspect`, then `onboard ctl reset`")]
    StoppedByFault,
    /// Somebody drives by hand, and another one wants to.
    #[error(
        "another teleoperator has it; wait until that one ends, or run `onboard ctl pause` to take it away"
    )]
    AnotherTeleoperator,
    /// What is not for a robot that somebody drives by hand.
    #[error("somebody drives it by hand; wait until that ends, or run `onboard ctl pause` first")]
    ByHand,
    /// After a reset, faults that are still there or have come back.
    #[error("the robot stays stopped by {}; reset it again when that is over", sentences(.0))]
    Remaining(Vec<Fault>),
    /// The robot is neither stopped nor paused, or still moves.
    #[error("the robot drives, or may: run `onboard ctl stop` first, and wait until it stands")]
    MayMove,
    /// Nobody counts its wheels' turns now; what has moved it since they were counted last would be added to where it is placed.
    #[error(
        "its drive does not answer, or what reads its wheels hangs (see `onboard inspect`), so that nobody sees it move: say where it stands when that is over"
    )]
    Unmeasured,
    /// The machine of this role has no such state.
    #[error("role `{role}` has no state `{state}`; it has {known}")]
    UnknownState {
        role: String,
        state: String,
        known: String,
    },
    /// An event was sent before, and navigation has not answered.
    #[error("another event still waits for navigation's answer")]
    AnotherEvent,
    /// An event or a reload while a reload is under way.
    #[error("a reload is under way")]
    AnotherReload,
    /// The machine of this role has no such external event.
    #[error("role `{role}` has no external event `{event}`; it has {known}")]
    UnknownEvent {
        role: String,
        event: String,
        known: String,
    },
    /// The state has no transition on the event.
    #[error("state `{state}` has no use for `{event}`; it takes {known}")]
    Ignored {
        state: String,
        event: String,
        known: String,
    },
    /// The parameters of the event are bad.
    #[error(transparent)]
    Instruction(#[from] InstructionError),
    /// Navigation is not in a state to take events.
    #[error("navigation does not run yet")]
    NotReady,
    /// It was asked before the computer slept.
    #[error("the computer has slept since: look where the robot is, and ask again")]
    Slept,
    /// The queue to navigation is full.
    #[error("navigation does not take its commands; see `onboard inspect` for what it does")]
    QueueFull,
    /// Navigation had its time to answer.
    #[error("navigation does not answer; see `onboard inspect` for what it does")]
    NoAnswer,
    /// The files cannot be used, or not by a robot that runs.
    #[error("{0}")]
    Files(String),
    /// A reload had its time; what it waited for.
    #[error("{0}")]
    ReloadTooSlow(&'static str),
}

/// Faults for people: what each is, and what to do.
fn sentences(faults: &[Fault]) -> String {
    let faults =
        { faults.iter() }.map(|fault| format!("`{}` ({})", fault.name(), fault.sentence()));
    faults.collect::<Vec<_>>().join(" and ")
}

/// Names for people: "`a`, `b`", or "none".
pub(crate) fn quoted<'a>(names: impl Iterator<Item = &'a String>) -> String {
    let names: Vec<String> = names.map(|name| format!("`{name}`")).collect();
    if names.is_empty() {
        "none".to_owned()
    } else {
        names.join(", ")
    }
}
