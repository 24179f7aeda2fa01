//! Keeps on the state's lane, or beside it, until a monitor ends it.

use super::behaviour::Behaviour;
use super::case::{Case, Lanes};
use super::motion::{Motion, Start};
use description::keys::KeyError;

/// Keeps on [`Schedule::lane`](crate::schedule::Schedule::lane), or beside it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Corridor {
    /// Of the path from the lane's centre, positive to the left.
    pub offset_m: f64,
}

impl Corridor {
    pub(super) fn plan(case: &Case, offset_m: f64) -> Result<(Self, Lanes), KeyError> {
        let lane = case.lane()?;
        case.check_offset(lane, offset_m)?;
        Ok((Self { offset_m }, case.on_lane(Some(lane))))
    }
}

impl Behaviour for Corridor {
    fn motion(&self, _start: &Start) -> Motion {
        Motion::Lane {
            offset_m: self.offset_m,
        }
    }

    fn offset_m(&self) -> f64 {
        self.offset_m
    }
}
