//! `[drive]` and `[control]`: the wheel unit, the limits of motion, and the gains of the motion thread.

use std::f64::consts::{FRAC_PI_2, FRAC_PI_4, PI};

use super::{ACCELERATION, GAIN, LENGTH, SPEED, TIMEOUT_MS};
use crate::keys::{ANGLE, Count, Quantity};
use crate::section;

const CURRENT: Quantity = Quantity::new("a current", "A").above(0.0).at_most(100.0);
const VOLTAGE: Quantity = Quantity::new("a voltage", "V").above(0.0).at_most(100.0);
const PIVOT: Quantity = Quantity::new("an angle", "rad").above(0.0).at_most(PI);

section! {
    /// The wheel unit's geometry and the limits of motion.
    #[derive(Copy)]
    pub struct Drive {
        /// From the fixed axle (`base_link`) forward to the unit's pivot.
        pub wheelbase_m: f64 as LENGTH,
        /// Diameter of each hub wheel.
        pub wheel_diameter_m: f64 as LENGTH,
        /// Between the two hub wheels.
        pub wheel_separation_m: f64 as LENGTH,
        /// How far the wheel axle trails behind the pivot.
        pub caster_offset_m: f64 as Quantity::new("a length", "m").at_least(0.0).at_most(5.0),
        /// What the pivot encoder reads when the unit points forward.
        pub pivot_zero_rad: f64 as ANGLE => 0.0,
        /// No wheel setpoint ever exceeds this.
        pub max_wheel_speed_rad_s: f64 as Quantity::new("a speed", "rad/s").above(0.0).at_most(100.0),
        /// Speed limit of `base_link`.
        pub max_speed_m_s: f64 as SPEED,
        /// Largest commanded steering (pivot) angle to either side.
        pub max_steering_rad: f64 as Quantity::new("an angle", "rad").above(0.0).at_most(FRAC_PI_2),
        /// Fastest change of the steering angle.
        pub max_steering_rate_rad_s: f64 as Quantity::new("a rate", "rad/s").above(0.0).at_most(50.0),
        /// Limit when speeding up.
        pub acceleration_m_s2: f64 as ACCELERATION,
        /// Limit when slowing down in normal driving.
        pub deceleration_m_s2: f64 as ACCELERATION,
        /// Deceleration of every stop for a fault.
        pub stop_deceleration_m_s2: f64 as ACCELERATION,
        /// Motor current limit while driving.
        pub drive_current_a: f64 as CURRENT,
        /// Motor current limit while standing.
        pub stop_current_a: f64 as CURRENT,
        /// Under this bus voltage the robot stops.
        pub min_bus_voltage_v: f64 as VOLTAGE,
        /// Over this bus voltage the robot stops.
        pub max_bus_voltage_v: f64 as VOLTAGE,
        /// A wheel setpoint older than this counts as none.
        pub setpoint_timeout_ms: u32 as TIMEOUT_MS => 50,
        /// Longest gap of lost frames that is bridged by holding the last setpoint.
        pub hold_ms: u32 as TIMEOUT_MS => 20,
        /// Automatic bring-ups within a minute; one more needs an operator.
        pub bringups_per_minute: u32 as Count::new("a count", 0, 60) => 3,
    }
}

section! {
    /// Gains of the motion thread, which turns motion commands into wheel setpoints.
    #[derive(Copy)]
    pub struct Control: Default {
        /// Pivot rate per radian of pivot error. 5 /s stays well damped with 50 ms between sensing and turning.
        pub pivot_gain_1_s: f64 as GAIN => 5.0,
        /// A larger pivot error counts as this one.
        pub pivot_error_max_rad: f64 as PIVOT => FRAC_PI_4,
        /// With a larger pivot error the unit turns in place before it rolls.
        pub align_rad: f64 as PIVOT => 0.6,
        /// A motion command older than this counts as none.
        pub command_timeout_ms: u32 as TIMEOUT_MS => 150,
    }
}
