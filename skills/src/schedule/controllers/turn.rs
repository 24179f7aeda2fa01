//! At a junction: from the lane of the state before onto the state's lane.

use super::behaviour::Behaviour;
use super::case::{Case, Lanes};
use super::motion::{Motion, Start};
use super::pace::{Pace, Progress};
use crate::control::manoeuvre::{self, Fillet};
use crate::control::{Arrival, Stopping, Track, TrackError};
use crate::schedule::graph::Towards;
use description::geometry::Pose2;
use description::keys::KeyError;

/// From [`Schedule::from_lane`](crate::schedule::Schedule::from_lane) onto
/// [`Schedule::lane`](crate::schedule::Schedule::lane), at a junction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Turn {
    /// Of the curve between them.
    pub radius_m: f64,
}

impl Turn {
    pub(super) fn plan(case: &Case, radius_m: f64) -> Result<(Self, Lanes), KeyError> {
        let to = case.lane()?;
        let from = case
            .graph
            .nearest_lane(case.state, Towards::Before, Some(to))
            .ok_or_else(|| case.no_lane("a lane to turn from"))?;
        let max_curvature_1_m = case.robot.max_curvature_1_m;
        let (incoming, outgoing) = (&case.geometry(from).line, &case.geometry(to).line);
        case.check_radius(radius_m)?;
        let check = || -> Result<Track, TrackError> {
            if let Some(fillet) = Fillet::between(incoming, outgoing, radius_m)? {
                fillet.check(outgoing, radius_m)?;
            }
            let start = Pose2::new(incoming.a.x_m, incoming.a.y_m, incoming.direction_rad());
            manoeuvre::turn(radius_m, max_curvature_1_m, incoming, outgoing, start)
        };
        let track = check().map_err(|error| case.impossible(error))?;
        if track.max_curvature_1_m() > 1e-3 {
            case.check_room(&track)?;
        }
        let lanes = Lanes {
            from_lane: Some(from),
            ..case.on_lane(Some(to))
        };
        Ok((Self { radius_m }, lanes))
    }
}

impl Behaviour for Turn {
    fn motion(&self, start: &Start) -> Motion {
        let Start {
            pose,
            max_curvature_1_m,
            ..
        } = *start;
        Motion::onto_lane(start, 0.0, Arrival::TURN, |onto| match start.from {
            Some(from) => manoeuvre::turn(self.radius_m, max_curvature_1_m, from, onto, pose),
            None => Ok(Track::lane(onto, pose.position())),
        })
    }

    fn pace(&self, motion: &Motion, _stopping: &mut Stopping, _now: &Progress) -> Pace {
        Pace::until_on_lane(motion)
    }

    fn least_way_m(&self, turn_rad: Option<f64>) -> f64 {
        turn_rad.map_or(0.0, |turn_rad| turn_rad.abs() * self.radius_m)
    }
}
