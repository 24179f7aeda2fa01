//! What a reload exchanges in navigation: the navigator, and what belongs to it.

use coordination::fsm::StateId;
use description::geometry::Pose2;
use skills::navigator::Navigator;

use super::names::Names;

/// Where the robot starts, and where an operator puts it when it is lost.
#[derive(Clone, Copy, Debug)]
pub struct Start {
    /// In `map`.
    pub pose: Pose2,
    /// Standard deviation of its position.
    pub std_m: f64,
    /// Standard deviation of its heading.
    pub std_rad: f64,
    /// State of the machine.
    pub state: StateId,
}

/// What a reload exchanges, made on another thread.
#[derive(Debug)]
pub struct Part {
    pub(super) navigator: Box<Navigator>,
    pub(super) names: Names,
    pub(super) start: Start,
}

impl Part {
    /// A navigator with where it starts, and the names that belong to it.
    #[must_use]
    pub fn new(navigator: Box<Navigator>, start: Start) -> Self {
        Self {
            names: Names::of(&navigator),
            navigator,
            start,
        }
    }
}
