//! Changes onto the state's lane from a lane beside it.

use super::behaviour::Behaviour;
use super::case::{Case, Lanes};
use super::motion::{Motion, Start};
use super::pace::{Pace, Progress};
use crate::control::{Arrival, Stopping, manoeuvre};
use description::keys::KeyError;
use description::site::ControllerConfig;

/// From beside [`Schedule::lane`](crate::schedule::Schedule::lane) onto it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Shift {
    /// Of the path on the lane from its centre, positive to the left.
    pub offset_m: f64,
    /// Length of the change,
    pub within_m: f64,
    /// which is planned for this way to the side; 0 where no lane comes before.
    pub aside_m: f64,
}

impl Shift {
    pub(super) fn plan(
        case: &Case,
        offset_m: f64,
        within_m: f64,
    ) -> Result<(Self, Lanes), KeyError> {
        let lane = case.lane()?;
        case.check_offset(lane, offset_m)?;
        let mut most_m: f64 = 0.0;
        for before in case.graph.just_before(case.state) {
            let Some(from) = case.graph.of(before).lane else {
                continue;
            };
            let before_m = match case.graph.skill(before).controller {
                ControllerConfig::Corridor { offset_m }
                | ControllerConfig::Shift { offset_m, .. } => offset_m,
                _ => 0.0,
            };
            let (from, to) = (&case.geometry(from).line, &case.geometry(lane).line);
            let aside_m = to.lateral_m(from.a) + before_m - offset_m;
            most_m = most_m.max(aside_m.abs());
            manoeuvre::check_beside(from, to)
                .and_then(|()| {
                    manoeuvre::check_shift(aside_m, within_m, case.robot.max_curvature_1_m)
                })
                .map_err(|error| case.impossible(error))?;
        }
        let shift = Self {
            offset_m,
            within_m,
            aside_m: most_m,
        };
        Ok((shift, case.on_lane(Some(lane))))
    }
}

impl Behaviour for Shift {
    fn motion(&self, start: &Start) -> Motion {
        Motion::onto_lane(start, self.offset_m, Arrival::SHIFT, |onto| {
            let max_curvature_1_m = start.max_curvature_1_m;
            // After a restart on the way a part of it is done.
            let aside_m = onto.lateral_m(start.pose.position()) - self.offset_m;
            let left = if self.aside_m > 0.0 {
                (aside_m.abs() / self.aside_m).min(1.0)
            } else {
                1.0
            };
            manoeuvre::shift(
                onto,
                self.offset_m,
                left * self.within_m,
                max_curvature_1_m,
                start.pose,
            )
        })
    }

    fn pace(&self, motion: &Motion, _stopping: &mut Stopping, _now: &Progress) -> Pace {
        Pace::until_on_lane(motion)
    }

    fn least_way_m(&self, _turn_rad: Option<f64>) -> f64 {
        self.within_m
    }
}
