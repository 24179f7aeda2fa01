//! What a member of a fleet senses and says, apart from messages.

use contract::wire;
use description::areas::AreaIndex;

use super::floor::UncertainPose;

/// What the robot knows of itself in one moment.
#[derive(Clone, Debug, Default)]
pub struct Sense {
    /// Where it is, if that is certain and recent.
    pub place: Option<UncertainPose>,
    /// The same for the message, with standard deviations.
    pub pose: Option<wire::Pose>,
    /// Forward speed.
    pub speed_m_s: f64,
    /// Number of the machine's state.
    pub state: Option<usize>,
    /// The area that keeps it from going on.
    pub waiting_for: Option<AreaIndex>,
}

/// What is wrong between robot and mediator, as levels.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Troubles {
    /// The mediator was not heard for too long, or the robot not by it.
    pub silent: bool,
    /// The mediator is heard, and has not said for too long that it hears the robot.
    pub unheard: bool,
    /// The mediator refuses this robot.
    pub refused: bool,
    /// Another process reports as this robot, and is refused.
    pub doubled: bool,
    /// Another mediator speaks than the one that is followed.
    pub second_mediator: bool,
    /// The mediator knows that the robot was somewhere before it restarted, but not where.
    pub lost: bool,
}
