//! A short way forward or backward along a direction, by dead reckoning and pose.

use super::law::{path_curvature, reverse_curvature};
use super::steer::{PathError, Steer};
use description::geometry::{Point2, Pose2, Segment, wrap_angle};
use description::robot::Navigation;

/// Creeping without a speed of its own, m/s.
pub const CREEP_SPEED_M_S: f64 = 0.10;
/// No skill creeps backward faster: the sensor looks ahead, and the pivot leads a trailing axle, m/s.
pub const MAX_BACKWARD_M_S: f64 = 0.20;

/// A creep under way: along a line through where it began.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Creep {
    line: Segment,
    distance_m: f64,
}

impl Creep {
    /// Starts at `pose` along `direction_rad`; a negative distance goes backward.
    #[must_use]
    pub fn start(pose: Pose2, direction_rad: f64, distance_m: f64) -> Self {
        let (sin, cos) = direction_rad.sin_cos();
        let from = pose.position();
        Self {
            line: Segment::new(from, from + Point2::new(cos, sin)),
            distance_m,
        }
    }

    /// Way that remains, positive whatever the direction; negative past the end.
    #[must_use]
    pub fn left_m(&self, pose: Pose2) -> f64 {
        let driven_m = self.line.along_m(pose.position());
        (self.distance_m - driven_m) * self.distance_m.signum()
    }

    /// One step at `pose` in `map`.
    #[must_use]
    pub fn step(&self, pose: Pose2, gains: &Navigation) -> Steer {
        let error = PathError {
            lateral_m: self.line.lateral_m(pose.position()),
            heading_rad: wrap_angle(pose.theta_rad - self.line.direction_rad()),
        };
        let backward = self.distance_m < 0.0;
        Steer {
            error,
            curvature_1_m: if backward {
                reverse_curvature(error, gains)
            } else {
                path_curvature(error, 0.0, gains)
            },
            path_curvature_1_m: 0.0,
            direction: if backward { -1.0 } else { 1.0 },
            speed_share: 1.0,
        }
    }
}
