//! Controllers: from where the robot is to the motion it should make.
//!
//! * [`path_curvature`]: the law that all of them steer by;
//! * [`Corridor`]: keeps on a lane;
//! * [`EndOfLane`]: the same, slows down, and is done at a distance from the wall at the end;
//! * [`UTurn`]: half a circle onto the other lane.
//!
//! Each gives a [`MotionCommand`] within the speed limit it is told, and says whether it is done. Pure and real time.

mod end_of_lane;
mod u_turn;

pub use end_of_lane::EndOfLane;
pub use u_turn::{TurnDirection, UTurn};

use crate::geometry::MotionCommand;

/// Steepest angle at which a lane is approached from the side, rad.
const APPROACH_RAD: f64 = 0.7;
/// However far off, the robot creeps at this share of the speed limit.
const SLOWEST_SHARE: f64 = 0.3;

/// How the controllers steer. The defaults suit a wheelbase of 0.25 m at up to 0.5 m/s.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ControlGains {
    /// Curvature per metre of lateral error. With the heading gain: a lateral error decays over a way of
    /// 2/`heading_gain_1_m`, without overshoot while `heading_gain_1_m`² ≥ 4·`lateral_gain_1_m2`.
    pub lateral_gain_1_m2: f64,
    /// Curvature per radian of heading error.
    pub heading_gain_1_m: f64,
    /// A large lateral error is approached as if aiming this far ahead on the lane.
    pub lookahead_m: f64,
    /// Tightest curve that is asked for.
    pub max_curvature_1_m: f64,
    /// Speeding up.
    pub acceleration_m_s2: f64,
    /// Slowing down where it can be foreseen.
    pub deceleration_m_s2: f64,
    /// From asking for a curve until the pivot has turned: manoeuvres begin and end so much earlier.
    pub steering_lag_s: f64,
}

impl Default for ControlGains {
    fn default() -> Self {
        Self {
            lateral_gain_1_m2: 4.0,
            heading_gain_1_m: 4.0,
            lookahead_m: 0.6,
            max_curvature_1_m: 2.5,
            acceleration_m_s2: 0.5,
            deceleration_m_s2: 0.4,
            steering_lag_s: 0.2,
        }
    }
}

/// Where the robot is relative to the path it should be on.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PathError {
    /// Positive to the left of the path.
    pub lateral_m: f64,
    /// Positive turned to the left of the path's direction.
    pub heading_rad: f64,
}

/// What a controller says.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ControlOutput {
    /// The motion to make.
    pub command: MotionCommand,
    /// Errors relative to the controller's path.
    pub error: PathError,
    /// The manoeuvre is finished.
    pub done: bool,
}

/// The curvature that leads back to a path of the given curvature.
///
/// Near the path it is linear in both errors; far away the lateral error asks for no more than a bounded approach angle.
#[must_use]
pub fn path_curvature(error: PathError, path_curvature_1_m: f64, gains: &ControlGains) -> f64 {
    let approach_rad = (error.lateral_m.abs() / gains.lookahead_m)
        .atan()
        .min(APPROACH_RAD);
    let wanted_rad = gains.lateral_gain_1_m2 / gains.heading_gain_1_m * error.lateral_m;
    let off_rad = error.heading_rad + wanted_rad.clamp(-approach_rad, approach_rad);
    let curvature = path_curvature_1_m - gains.heading_gain_1_m * off_rad;
    curvature.clamp(-gains.max_curvature_1_m, gains.max_curvature_1_m)
}

/// Share of the speed limit that is sensible this far off the path.
fn speed_share(error: PathError) -> f64 {
    let turned = error.heading_rad.cos().max(0.0);
    let aside = 1.0 / (1.0 + (2.0 * error.lateral_m).powi(2));
    (turned * aside).max(SLOWEST_SHARE)
}

/// Keeps on a lane.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Corridor;

impl Corridor {
    /// One step: `error` relative to the lane.
    #[must_use]
    pub fn step(
        self,
        error: PathError,
        speed_limit_m_s: f64,
        gains: &ControlGains,
    ) -> ControlOutput {
        ControlOutput {
            command: MotionCommand::new(
                speed_limit_m_s * speed_share(error),
                path_curvature(error, 0.0, gains),
            ),
            error,
            done: false,
        }
    }
}

#[cfg(test)]
mod tests;
