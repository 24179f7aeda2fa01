//! What a reload exchanges in navigation: the navigator, and what belongs to it.

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
