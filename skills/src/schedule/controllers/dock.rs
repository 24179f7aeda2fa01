//! Drives up to the wall at the lane's end, by what the lidar measures of it, and stops.

use super::behaviour::Behaviour;
use super::case::{Case, Lanes};
use super::motion::Motion;
use super::pace::{Hold, Pace, Progress};
use crate::control::{Stopping, approach_speed_m_s};
use description::geometry::Point2;
use description::keys::KeyError;

/// Least distance between front and wall: closer, the lidar cannot measure it.
const NEAREST_DOCK_M: f64 = 0.05;
/// Within this distance of the end, docking is limited to this speed.
const DOCK_SLOW_M: f64 = 1.0;
const DOCK_SPEED_M_S: f64 = 0.15;
/// Without a measured wall, docking stops this far before where the map has the wall.
const DOCK_BLIND_M: f64 = 0.5;

/// Up to the wall that closes [`Schedule::lane`](crate::schedule::Schedule::lane).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Dock {
    /// From the front of the footprint to the wall.
    pub distance_m: f64,
}

impl Dock {
    pub(super) fn plan(case: &Case, distance_m: f64) -> Result<(Self, Lanes), KeyError> {
        let lane = case.lane()?;
        if case.geometry(lane).end.is_none() {
            return Err(case.no_lane("a lane that a wall closes, to dock at"));
        }
        if distance_m < NEAREST_DOCK_M {
            return Err(case.impossible(format!(
                "docking {distance_m} m before a wall is closer than the {NEAREST_DOCK_M} m that can be measured"
            )));
        }
        Ok((Self { distance_m }, case.on_lane(Some(lane))))
    }
}

impl Behaviour for Dock {
    fn pace(&self, _motion: &Motion, stopping: &mut Stopping, now: &Progress) -> Pace {
        let Some(wall) = now.end_wall else {
            return Pace::standing(Hold::WallUnseen);
        };
        // Towards the wall, from the side that the robot is on.
        let unit = wall.line.unit();
        let side = -wall.line.lateral_m(now.pose.position()).signum();
        let towards = Point2::new(-unit.y_m, unit.x_m) * side;
        let front_m = now
            .footprint
            .corners()
            .map(|corner| now.pose.rotate(corner).dot(towards))
            .into_iter()
            .fold(f64::NEG_INFINITY, f64::max);
        let left_m = now.end_m - front_m - self.distance_m;
        let blind_m = left_m - DOCK_BLIND_M;
        let deceleration_m_s2 = now.gains.deceleration_m_s2;
        if !now.end_measured && !stopping.arrived() {
            if blind_m <= 0.02 {
                return Pace::standing(Hold::WallUnseen);
            }
            return Pace {
                speed_m_s: approach_speed_m_s(blind_m, 0.0, deceleration_m_s2),
                left_m: blind_m,
                ..Pace::FREE
            };
        }
        let slow_m_s = approach_speed_m_s(left_m - DOCK_SLOW_M, DOCK_SPEED_M_S, deceleration_m_s2);
        let pace = now.stop(stopping, left_m);
        Pace {
            speed_m_s: pace.speed_m_s.min(slow_m_s),
            ..pace
        }
    }
}
