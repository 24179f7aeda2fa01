//! `[drive]` and `[control]`: the wheel unit, the limits of motion, and the gains of the motion thread.

use std::f64::consts::{FRAC_PI_2, FRAC_PI_4, PI};

use super::{ACCELERATION, GAIN, LENGTH, TIMEOUT_MS};
use crate::geometry::Twist2;
use crate::keys::{ANGLE, Count, Flat, KeyError, Quantity, SPEED, Section, Truth};
use crate::section;

const CURRENT: Quantity = Quantity::new("a current", "A").above(0.0).at_most(100.0);
const VOLTAGE: Quantity = Quantity::new("a voltage", "V").above(0.0).at_most(100.0);
const PIVOT: Quantity = Quantity::new("an angle", "rad").above(0.0).at_most(PI);

section! {
    /// Measures of the wheel unit, and where it sits.
    #[derive(Copy)]
    pub struct TricycleGeometry {
        /// From the fixed axle (`base_link`) forward to the unit's pivot.
        pub wheelbase_m: f64 as LENGTH,
        /// Diameter of each hub wheel.
        pub wheel_diameter_m: f64 as LENGTH,
        /// Between the two hub wheels.
        pub wheel_separation_m: f64 as LENGTH,
        /// How far the wheel axle trails behind the pivot.
        pub caster_offset_m: f64 as Quantity::new("a length", "m").at_least(0.0).at_most(5.0),
    }
}

section! {
    /// What the drive may do.
    #[derive(Copy)]
    pub struct DriveLimits {
        /// No wheel setpoint ever exceeds this. The drive takes no faster one (product specification of the KELO wheel drive).
        pub max_wheel_speed_rad_s: f64 as Quantity::new("a speed", "rad/s").above(0.0).at_most(35.0),
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
    }
}

section! {
    /// The wheel unit's geometry and the limits of motion.
    #[derive(Copy)]
    pub struct Drive {
        /// Measures.
        pub geometry: TricycleGeometry as Flat,
        /// What the pivot encoder reads when the unit points forward.
        pub pivot_zero_rad: f64 as ANGLE => 0.0,
        /// Limits of motion.
        pub limits: DriveLimits as Flat,
        /// Least deceleration of the robot while its motors have no power, as when its drive hears nothing more: it coasts, or
        /// brakes where the drive shorts its motors. To be measured.
        pub unpowered_deceleration_m_s2: f64 as ACCELERATION,
        /// From a setpoint until the wheels turn as told.
        pub lag_ms: u32 as TIMEOUT_MS => 20,
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
        /// Bring-ups of a lost bus within a minute, attempts in vain included; one more needs an operator.
        pub bringups_per_minute: u32 as Count::new("a count", 1, 16) => 3,
        /// How long a program that starts afresh waits for its drive, and drives by itself when it comes. One that comes later waits
        /// for an operator: it may have been the emergency stop that was released.
        pub awaited_s: f64 as Quantity::new("a duration", "s").at_least(0.0).at_most(60.0) => 1.0,
        /// How far a wheel's rim may move within a second beyond what the wheel was told, before the robot stops until an
        /// operator has looked.
        pub following_error_m: f64 as Quantity::new("a length", "m").above(0.0).at_most(0.5) => 0.02,
        /// Whether the drive's emergency bits are set when a wheel does not obey, so that it stops by itself, in its own way; and
        /// once the robot stands after a drive fault, a bad voltage or an emergency stop: it then has no power until it is reset.
        pub emergency_bits: bool as Truth => false,
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

impl Default for TricycleGeometry {
    /// A KELO drive 100 under a platform of 0.4 m × 0.3 m.
    fn default() -> Self {
        Self {
            wheelbase_m: 0.25,
            wheel_diameter_m: 0.105,
            wheel_separation_m: 0.0775,
            caster_offset_m: 0.01,
        }
    }
}

impl TricycleGeometry {
    /// Half the diameter.
    #[must_use]
    pub fn wheel_radius_m(&self) -> f64 {
        self.wheel_diameter_m / 2.0
    }

    /// Checks that the numbers describe a vehicle.
    ///
    /// # Errors
    /// The first key of `[drive]` that describes none.
    pub fn validate(&self) -> Result<(), KeyError> {
        self.check().map_err(|error| error.below("drive"))?;
        if self.caster_offset_m >= self.wheelbase_m / 2.0 {
            return Err(KeyError::new(
                "drive.caster_offset_m",
                format!("{:?}", self.caster_offset_m),
                format!("below half of `wheelbase_m`, {} m", self.wheelbase_m),
            ));
        }
        Ok(())
    }

    /// Twist of `base_link` from the unit's speed, the pivot angle and its rate.
    #[must_use]
    pub fn twist(&self, unit_m_s: f64, pivot_rad: f64, pivot_rate_rad_s: f64) -> Twist2 {
        let (sin, cos) = pivot_rad.sin_cos();
        let caster_m = self.caster_offset_m;
        let omega_rad_s = (unit_m_s * sin + caster_m * pivot_rate_rad_s * cos)
            / (self.wheelbase_m - caster_m * cos);
        let v_m_s = unit_m_s * cos - caster_m * (omega_rad_s + pivot_rate_rad_s) * sin;
        Twist2::new(v_m_s, omega_rad_s)
    }
}

impl Default for DriveLimits {
    /// The platform of 0.4 m × 0.3 m.
    fn default() -> Self {
        Self {
            max_wheel_speed_rad_s: 35.0,
            max_speed_m_s: 0.4,
            max_steering_rad: 1.2,
            max_steering_rate_rad_s: 3.0,
            acceleration_m_s2: 0.5,
            deceleration_m_s2: 0.8,
            stop_deceleration_m_s2: 2.0,
        }
    }
}

impl DriveLimits {
    /// Checks every limit.
    ///
    /// # Errors
    /// The first key of `[drive]` that no drive can have.
    pub fn validate(&self) -> Result<(), KeyError> {
        self.check().map_err(|error| error.below("drive"))?;
        if self.max_steering_rad >= FRAC_PI_2 {
            let found = format!("{:?}", self.max_steering_rad);
            return Err(KeyError::new(
                "drive.max_steering_rad",
                found,
                "an angle below π/2",
            ));
        }
        Ok(())
    }
}
