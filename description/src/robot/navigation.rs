//! `[navigation]`: controllers, feature trackers, and the pose.

use std::f64::consts::PI;

use super::{ACCELERATION, GAIN};
use crate::keys::{Count, Quantity};
use crate::section;

const INLIER: Quantity = Quantity::new("a length", "m").above(0.0).at_most(1.0);
const SIGMAS: Quantity = Quantity::new("a number of standard deviations", "")
    .at_least(1.0)
    .at_most(10.0);
const STD_M: Quantity = Quantity::new("a standard deviation", "m")
    .above(0.0)
    .at_most(10.0);
const STD_RAD: Quantity = Quantity::new("a standard deviation", "rad")
    .above(0.0)
    .at_most(PI);
const STD_RATE: Quantity = Quantity::new("a standard deviation per metre", "")
    .above(0.0)
    .at_most(1.0);

section! {
    /// Gains of controllers and feature trackers, and when the pose is too uncertain to drive. The defaults drive the
    /// platform of 0.4 m × 0.3 m.
    #[derive(Copy)]
    pub struct Navigation: Default {
        /// Curvature (1/m) per metre of lateral error.
        pub lateral_gain_1_m2: f64 as GAIN => 4.0,
        /// Curvature (1/m) per radian of heading error; at least 2·√`lateral_gain_1_m2` does not overshoot.
        pub heading_gain_1_m: f64 as GAIN => 4.0,
        /// Large lateral errors are approached as if aiming this far ahead.
        pub lookahead_m: f64 as Quantity::new("a length", "m").above(0.0).at_most(5.0) => 0.6,
        /// Tightest curvature that navigation asks for.
        pub max_curvature_1_m: f64 as Quantity::new("a curvature", "1/m").above(0.0).at_most(20.0) => 2.5,
        /// Deceleration where slowing down can be foreseen: before a lane's end, a stop, a border.
        pub deceleration_m_s2: f64 as ACCELERATION => 0.4,
        /// From asking for a curve until the pivot has turned: manoeuvres begin and end this much earlier.
        pub steering_lag_s: f64 as Quantity::new("a duration", "s").at_least(0.0).at_most(2.0) => 0.2,
        /// A scan point within this distance of a line belongs to it.
        pub wall_inlier_m: f64 as INLIER => 0.05,
        /// Points that make a wall, at least.
        pub wall_min_points: u32 as Count::new("a count", 2, 10_000) => 12,
        /// Standard deviation of one range, at least.
        pub range_std_m: f64 as INLIER => 0.01,
        /// Measurements farther off than this many standard deviations are refused.
        pub gate_sigma: f64 as SIGMAS => 4.0,
        /// Growth of the position's standard deviation over one metre driven (with the root of the distance).
        pub odometry_std_m_per_m: f64 as STD_RATE => 0.03,
        /// Growth of the heading's standard deviation over one metre driven (with the root of the distance).
        pub odometry_std_rad_per_m: f64 as STD_RATE => 0.03,
        /// Standard deviation of the start position.
        pub start_std_m: f64 as STD_M => 0.10,
        /// Standard deviation of the start heading.
        pub start_std_rad: f64 as STD_RAD => 0.10,
        /// Above this standard deviation of the position the robot stops.
        pub max_std_m: f64 as STD_M => 0.30,
        /// Above this standard deviation of the heading the robot stops.
        pub max_std_rad: f64 as STD_RAD => 0.30,
        /// Margin to borders, and to stops before them, in standard deviations of the pose.
        pub border_sigma: f64 as SIGMAS => 3.0,
        /// How far the pose may be off besides, since map or lidar are wrong alike in all scans, which its standard deviation does not
        /// count: it is kept from borders too. Measure it: the URG-04LX may be 1 % off, 3 cm at 3 m.
        pub map_error_m: f64 as Quantity::new("a length", "m").at_least(0.0).at_most(0.05) => 0.0,
    }
}
