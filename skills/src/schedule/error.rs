//! Why skills, states and map do not fit together.

/// Why no schedules can be made.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum ScheduleError {
    /// A state of the machine has no meaning, or two.
    #[error("state `{state}` of the machine is described {found} times, expected once")]
    State {
        /// The state.
        state: String,
        /// How often it is described.
        found: usize,
    },
    /// A name that nothing has.
    #[error("{kind} `{id}` names the {wanted} `{name}`, which does not exist")]
    Unknown {
        /// What names it.
        kind: &'static str,
        /// Its name.
        id: String,
        /// What is named.
        wanted: &'static str,
        /// The name that nothing has.
        name: String,
    },
    /// The controller needs a lane.
    #[error("state `{state}` needs {wanted}, and neither its area nor its neighbours give one")]
    NoLane {
        /// The state.
        state: String,
        /// Which lane.
        wanted: &'static str,
    },
    /// A parameter is not a positive number.
    #[error("{what} of skill `{skill}` must be {expected}, found {found}")]
    Parameter {
        /// The skill.
        skill: String,
        /// Which parameter.
        what: &'static str,
        /// What is expected.
        expected: &'static str,
        /// Found.
        found: f64,
    },
    /// A time that is not positive.
    #[error("seconds of monitor `{monitor}` must be positive, found {found_s}")]
    Monitor {
        /// The monitor.
        monitor: String,
        /// Found.
        found_s: f64,
    },
    /// A manoeuvre that cannot be driven.
    #[error("state `{state}` cannot be driven: {reason}")]
    Manoeuvre {
        /// The state.
        state: String,
        /// Why.
        reason: String,
    },
    /// A U-turn leads away from its outgoing lane.
    #[error(
        "the U-turn in state `{state}` turns away from lane `{outgoing}`, which lies on the other side of `{incoming}`"
    )]
    TurnSide {
        /// The state.
        state: String,
        /// Where it comes from.
        incoming: String,
        /// Where it should lead.
        outgoing: String,
    },
}
