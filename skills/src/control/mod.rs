//! Controllers: from where the robot is to the motion it should make. Steering and speed are told apart.
//!
//! Steering:
//! * [`path_curvature`] and [`reverse_curvature`]: the laws that all of them steer by;
//! * [`keep_lane`]: on a lane, or beside it;
//! * [`Track`] and [`Follower`]: along the path of a manoeuvre onto a lane; [`manoeuvre`] makes the paths of U-turns,
//!   junction turns and shifts, and says why there is none;
//! * [`Creep`]: a short way forward or backward.
//!
//! Speed:
//! * [`approach_speed_m_s`]: slow enough for what comes;
//! * [`EndOfLane`], [`Stopping`]: done at a place, with a speed or at rest;
//! * [`SpeedRamp`]: no jumps.
//!
//! Pure and real time: nothing allocates, locks or panics.

mod approach;
mod creep;
mod end_of_lane;
mod follow;
mod law;
pub mod manoeuvre;
mod ramp;
mod track;

pub(crate) use approach::REACTION_S;
pub use approach::{Stopping, approach_speed_m_s};
pub use creep::{CREEP_SPEED_M_S, Creep, MAX_BACKWARD_M_S};
pub use end_of_lane::EndOfLane;
pub use follow::{Arrival, Follower};
pub use law::{path_curvature, reverse_curvature, speed_share};
pub use manoeuvre::TrackError;
pub use ramp::SpeedRamp;
pub use track::{Track, TrackPlace};

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

/// To which side.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TurnDirection {
    /// Counter-clockwise.
    Left,
    /// Clockwise.
    Right,
}

impl TurnDirection {
    /// +1 to the left, −1 to the right.
    #[must_use]
    pub fn sign(self) -> f64 {
        match self {
            Self::Left => 1.0,
            Self::Right => -1.0,
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

/// How to steer.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Steer {
    /// Relative to the path.
    pub error: PathError,
    /// Turning per metre driven forward, positive to the left.
    pub curvature_1_m: f64,
    /// +1 forward, −1 backward.
    pub direction: f64,
    /// Of the path there.
    pub path_curvature_1_m: f64,
    /// Of the speed limit, what is sensible with this error.
    pub speed_share: f64,
}

/// Keeps on a straight path: `error` relative to it.
#[must_use]
pub fn keep_lane(error: PathError, gains: &ControlGains) -> Steer {
    Steer {
        error,
        curvature_1_m: path_curvature(error, 0.0, gains),
        path_curvature_1_m: 0.0,
        direction: 1.0,
        speed_share: speed_share(error),
    }
}

#[cfg(test)]
mod tests;
