//! What every controller answers while its state lasts.

use super::motion::{Motion, Start};
use super::pace::{Pace, Progress};
use crate::control::Stopping;

/// A controller with its parameters. Real time: nothing allocates, locks or panics.
pub(crate) trait Behaviour {
    /// How it moves the robot; by default along the centre of the state's lane.
    fn motion(&self, _start: &Start) -> Motion {
        Motion::Lane { offset_m: 0.0 }
    }

    /// How fast the robot may be, and whether it is there. By default monitors end the state.
    fn pace(&self, _motion: &Motion, _stopping: &mut Stopping, _now: &Progress) -> Pace {
        Pace::FREE
    }

    /// How a robot that stands past its end comes back to it; none where it cannot help itself.
    fn back_up(&self, _now: &Progress) -> Option<Motion> {
        None
    }

    /// The offset from the lane's centre that it keeps, positive to the left.
    fn offset_m(&self) -> f64 {
        0.0
    }

    /// The way from its beginning to its end, at least; `turn_rad` is the angle between the lanes that it joins.
    fn least_way_m(&self, _turn_rad: Option<f64>) -> f64 {
        0.0
    }
}
