//! What a navigator is made of, as plain data, and the checks.

use crate::control::ControlGains;
use crate::localisation::PoseGains;
use crate::map::{MapData, MapError};
use crate::perception::PerceptionGains;
use crate::schedule::{MonitorSetup, ScheduleError, SkillSetup, StateSetup};
use coordination::fsm::Machine;
use description::geometry::{Footprint, Pose2};

/// Everything that a [`Navigator`](super::Navigator) needs to know.
#[derive(Clone, Debug)]
pub struct NavigatorSetup {
    /// Walls, lanes, areas.
    pub map: MapData,
    /// The robot's machine; its inputs are the monitors' events and what others post.
    pub machine: Machine,
    /// What each state of the machine means.
    pub states: Vec<StateSetup>,
    /// What can run.
    pub skills: Vec<SkillSetup>,
    /// What can raise events.
    pub monitors: Vec<MonitorSetup>,
    /// How it estimates and steers.
    pub gains: NavigationGains,
    /// The robot's own speed limit.
    pub max_speed_m_s: f64,
    /// The robot's outline.
    pub footprint: Footprint,
    /// Beams of a scan, at most.
    pub beams: usize,
    /// Where the robot starts, in `map`.
    pub start: Pose2,
    /// In which state; by default the machine's initial one.
    pub start_state: Option<String>,
}

/// All gains of navigation. The defaults drive the platform of 0.4 m × 0.3 m.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NavigationGains {
    /// Curvature per metre of lateral error.
    pub lateral_gain_1_m2: f64,
    /// Curvature per radian of heading error; at least 2·√lateral gain does not overshoot.
    pub heading_gain_1_m: f64,
    /// Large lateral errors are approached as if aiming this far ahead.
    pub lookahead_m: f64,
    /// Tightest curve that is asked for.
    pub max_curvature_1_m: f64,
    /// Speeding up.
    pub acceleration_m_s2: f64,
    /// Slowing down where it can be foreseen: before a lane's end, a stop, a border.
    pub deceleration_m_s2: f64,
    /// Manoeuvres begin and end so much earlier, for the pivot to turn.
    pub steering_lag_s: f64,
    /// A scan point this near to a line belongs to it.
    pub wall_inlier_m: f64,
    /// Points that make a wall.
    pub wall_min_points: u32,
    /// Noise of one range, at least.
    pub range_std_m: f64,
    /// Measurements farther off than this many standard deviations are refused.
    pub gate_sigma: f64,
    /// Growth of the position's standard deviation over one metre driven (with the root of the way).
    pub odometry_std_m_per_m: f64,
    /// The same of the heading.
    pub odometry_std_rad_per_m: f64,
    /// How well the start position is known.
    pub start_std_m: f64,
    /// How well the start heading is known.
    pub start_std_rad: f64,
    /// With a less certain position the robot stops.
    pub max_std_m: f64,
    /// With a less certain heading the robot stops.
    pub max_std_rad: f64,
    /// Borders and stops before them keep a margin of so many standard deviations of the pose.
    pub border_sigma: f64,
}

impl Default for NavigationGains {
    fn default() -> Self {
        let (control, perception, pose) = (
            ControlGains::default(),
            PerceptionGains::default(),
            PoseGains::default(),
        );
        Self {
            lateral_gain_1_m2: control.lateral_gain_1_m2,
            heading_gain_1_m: control.heading_gain_1_m,
            lookahead_m: control.lookahead_m,
            max_curvature_1_m: control.max_curvature_1_m,
            acceleration_m_s2: control.acceleration_m_s2,
            deceleration_m_s2: control.deceleration_m_s2,
            steering_lag_s: control.steering_lag_s,
            wall_inlier_m: perception.inlier_m,
            wall_min_points: perception.min_points as u32,
            range_std_m: perception.range_std_m,
            gate_sigma: perception.gate_sigma,
            odometry_std_m_per_m: perception.odometry_std_m_per_m,
            odometry_std_rad_per_m: perception.odometry_std_rad_per_m,
            start_std_m: 0.10,
            start_std_rad: 0.10,
            max_std_m: pose.max_std_m,
            max_std_rad: pose.max_std_rad,
            border_sigma: 3.0,
        }
    }
}

impl NavigationGains {
    /// Those of the controllers.
    #[must_use]
    pub fn control(&self) -> ControlGains {
        ControlGains {
            lateral_gain_1_m2: self.lateral_gain_1_m2,
            heading_gain_1_m: self.heading_gain_1_m,
            lookahead_m: self.lookahead_m,
            max_curvature_1_m: self.max_curvature_1_m,
            acceleration_m_s2: self.acceleration_m_s2,
            deceleration_m_s2: self.deceleration_m_s2,
            steering_lag_s: self.steering_lag_s,
        }
    }

    /// Those of the trackers.
    #[must_use]
    pub fn perception(&self) -> PerceptionGains {
        PerceptionGains {
            inlier_m: self.wall_inlier_m,
            min_points: self.wall_min_points as usize,
            range_std_m: self.range_std_m,
            gate_sigma: self.gate_sigma,
            odometry_std_m_per_m: self.odometry_std_m_per_m,
            odometry_std_rad_per_m: self.odometry_std_rad_per_m,
        }
    }

    /// Those of the pose.
    #[must_use]
    pub fn pose(&self) -> PoseGains {
        PoseGains {
            odometry_std_m_per_m: self.odometry_std_m_per_m,
            odometry_std_rad_per_m: self.odometry_std_rad_per_m,
            gate_sigma: self.gate_sigma,
            max_std_m: self.max_std_m,
            max_std_rad: self.max_std_rad,
        }
    }

    /// Checks that every gain is a positive number; the steering lag may be 0.
    pub(crate) fn validate(&self) -> Result<(), SetupError> {
        let positive = [
            ("lateral gain", self.lateral_gain_1_m2),
            ("heading gain", self.heading_gain_1_m),
            ("lookahead", self.lookahead_m),
            ("maximum curvature", self.max_curvature_1_m),
            ("acceleration", self.acceleration_m_s2),
            ("deceleration", self.deceleration_m_s2),
            ("wall inlier distance", self.wall_inlier_m),
            ("points of a wall", f64::from(self.wall_min_points)),
            ("range noise", self.range_std_m),
            ("gate", self.gate_sigma),
            ("odometry noise", self.odometry_std_m_per_m),
            ("odometry heading noise", self.odometry_std_rad_per_m),
            ("start uncertainty", self.start_std_m),
            ("start heading uncertainty", self.start_std_rad),
            ("position uncertainty limit", self.max_std_m),
            ("heading uncertainty limit", self.max_std_rad),
            ("border margin", self.border_sigma),
        ];
        for (what, found) in positive {
            if !(found.is_finite() && found > 0.0) {
                return Err(SetupError::NotPositive { what, found });
            }
        }
        let lag_s = self.steering_lag_s;
        if !(0.0..=2.0).contains(&lag_s) {
            return Err(SetupError::SteeringLag(lag_s));
        }
        Ok(())
    }
}

/// Why no navigator can be made of a setup.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum SetupError {
    /// The map.
    #[error(transparent)]
    Map(#[from] MapError),
    /// Skills, states and monitors.
    #[error(transparent)]
    Schedule(#[from] ScheduleError),
    /// A number that must be positive.
    #[error("{what} must be positive, found {found}")]
    NotPositive {
        /// Which.
        what: &'static str,
        /// Found.
        found: f64,
    },
    /// The steering lag.
    #[error("steering lag must lie between 0 and 2 s, found {0} s")]
    SteeringLag(f64),
    /// The robot's outline.
    #[error("all four distances of the footprint from base_link must be positive")]
    Footprint,
    /// The start pose.
    #[error("start pose is not finite")]
    Start,
    /// The start state.
    #[error("start state `{0}` is not a state of the machine")]
    StartState(String),
}
