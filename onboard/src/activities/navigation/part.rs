//! What a reload exchanges in navigation: the navigator, and what belongs to it.

use description::robot::Teleop;
use skills::navigator::Navigator;

use super::names::Names;
use crate::fleet::Start;

/// What a reload exchanges, made on another thread.
#[derive(Debug)]
pub struct Part {
    pub(super) navigator: Box<Navigator>,
    pub(super) names: Names,
    /// Where the robot starts, and where an operator puts it when it is lost.
    pub(super) start: Start,
    /// How it is driven by hand.
    pub(super) teleop: Teleop,
}

impl Part {
    /// A navigator with where it starts, how it is driven by hand, and the names that belong to it.
    #[must_use]
    pub fn new(navigator: Box<Navigator>, start: Start, teleop: Teleop) -> Self {
        Self {
            names: Names::of(&navigator),
            navigator,
            start,
            teleop,
        }
    }
}
