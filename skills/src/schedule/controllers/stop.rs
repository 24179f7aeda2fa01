//! Stands still.

use super::behaviour::Behaviour;
use super::motion::{Motion, Start};

/// No parameters.
pub(super) struct Stop;

impl Behaviour for Stop {
    fn motion(&self, _start: &Start) -> Motion {
        Motion::Still
    }
}
