//! What goes in and out of a member of a fleet beside messages.

use contract::wire;

use super::floor::Place;

/// What the robot knows of itself in one moment.
#[derive(Clone, Debug, Default)]
pub struct Sense {
    /// Where it is, if that is certain and recent.
    pub place: Option<Place>,
    /// The same for the message, with what it may be wrong by.
    pub pose: Option<wire::Pose>,
    /// Forward speed.
    pub speed_m_s: f64,
    /// Number of the machine's state.
    pub state: Option<usize>,
    /// The area that keeps it from going on, by its number.
    pub waiting_for: Option<usize>,
}

/// What is wrong between robot and mediator, as levels.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Troubles {
    /// Nothing was heard of it for too long.
    pub silent: bool,
    /// It does not want this robot.
    pub refused: bool,
    /// It knows that the robot was somewhere before it restarted, but not where.
    pub lost: bool,
}

/// For people and other programs.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Standing {
    /// The mediator's epoch, 0 before it spoke.
    pub mediator_epoch: u64,
    /// The registration, 0 without one.
    pub session: u64,
    /// The mediator has the discrete control.
    pub acquired: bool,
    /// The coordination under way, 0 for none.
    pub coordination: u64,
    /// Its net with the flags set so far.
    pub net: String,
    /// Areas that the robot may be in.
    pub holds: String,
    /// Areas that it waits for and why, and orders that wait for the machine.
    pub waits: String,
}
