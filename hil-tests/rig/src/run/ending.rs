//! How a run ends.

use std::process::ExitStatus;

/// How a run ended.
#[derive(Clone, Debug, PartialEq)]
pub enum Ending {
    /// All goals are reached.
    Done,
    /// A signal interrupted it.
    Interrupted,
    /// The scenario's patience is over.
    TooSlow,
    /// No robot has moved for the scenario's longest standstill.
    Standstill,
    /// A robot has had a fault, named here, since this time, that only an operator can clear, and that no operator is to clear.
    Stranded(&'static str, u64),
    /// A robot ended by itself.
    RobotEnded(String, ExitStatus),
    /// The mediator ended by itself.
    MediatorEnded(ExitStatus),
    /// A run on the simulated clock panicked, or could not go on, for this reason.
    BrokenOff(String),
}
