//! From a wanted motion to the speeds of the two hub wheels.
//!
//! The unit is steered by the difference of its wheels. [`WheelController`] turns the pivot towards the angle whose path
//! has the wanted curvature (the caster included), with a proportional law and a rate limit, and drives the unit as fast
//! as the cosine of the pivot error allows, not at all while the error is large: it never drives off in a wrong
//! direction. Speed follows acceleration limits, and no wheel is commanded beyond its limit.
//!
//! [`Obedience`] watches whether the wheels then do what they were told.
//!
//! Real time: [`WheelController::step`] does not allocate, lock or panic; it stops on input that is not finite.

mod obedience;
mod window;

pub use obedience::{Disobedience, Obedience, Part};

use description::geometry::{MotionCommand, wrap_angle};
use description::keys::{KeyError, Section};
use description::robot::{Control, DriveLimits, TricycleGeometry};
use description::wheels::WheelSpeeds;

/// Wheels slower than this stand.
pub const STANDING_RAD_S: f64 = 0.2;
/// How far the ramp may run ahead of the measured speed before it waits, m/s.
const RAMP_AHEAD_M_S: f64 = 0.2;
/// Below this the unit counts as standing, m/s.
const STANDING_M_S: f64 = 1e-3;
/// Longer control steps count as this long, s.
const LONGEST_STEP_S: f64 = 0.1;

/// Whether to follow the command, or how to stop.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum StopKind {
    /// Follow the command.
    #[default]
    None,
    /// Stop at the ordinary deceleration, pivot held.
    Gentle,
    /// Stop at the stop deceleration, pivot held.
    Hard,
}

/// The controller between a motion command and the wheels.
#[derive(Clone, Debug)]
pub struct WheelController {
    geometry: TricycleGeometry,
    limits: DriveLimits,
    gains: Control,
    /// Ramped speed of the unit along its heading.
    unit_m_s: f64,
    /// A stop for a fault is under way.
    stops_hard: bool,
}

impl WheelController {
    /// A controller at standstill.
    ///
    /// # Errors
    /// The first key of `[drive]` or `[control]` that does not fit.
    pub fn new(
        geometry: TricycleGeometry,
        limits: DriveLimits,
        gains: Control,
    ) -> Result<Self, KeyError> {
        geometry.validate()?;
        limits.validate()?;
        gains.check().map_err(|error| error.below("control"))?;
        Ok(Self {
            geometry,
            limits,
            gains,
            unit_m_s: 0.0,
            stops_hard: false,
        })
    }

    /// The limits in force.
    #[must_use]
    pub fn limits(&self) -> &DriveLimits {
        &self.limits
    }

    /// Speed of the unit that the ramp has reached.
    #[must_use]
    pub fn unit_speed_m_s(&self) -> f64 {
        self.unit_m_s
    }

    /// Starts the ramp at what the wheels do now: after a bring-up, or a pause with motors off.
    pub fn reset(&mut self, measured: WheelSpeeds) {
        let unit_m_s = self.unit_speed_of(measured);
        let limit_m_s = self.limits.max_wheel_speed_rad_s * self.geometry.wheel_radius_m();
        self.unit_m_s = if unit_m_s.is_finite() {
            unit_m_s.clamp(-limit_m_s, limit_m_s)
        } else {
            0.0
        };
    }

    /// The pivot angle whose steady path has this curvature, within the steering limit.
    #[must_use]
    pub fn steering_for(&self, curvature_1_m: f64) -> f64 {
        // The pivot point moves along (1, L·κ); the unit's heading leads it by what the trailing axle adds.
        let slope = self.geometry.wheelbase_m * curvature_1_m;
        let lead = self.geometry.caster_offset_m * curvature_1_m / slope.hypot(1.0);
        (slope.atan() - lead.clamp(-1.0, 1.0).asin())
            .clamp(-self.limits.max_steering_rad, self.limits.max_steering_rad)
    }

    /// One control step. `pivot_rad` and `measured` are the latest from the drive; `dt_s` is the time since the last step.
    pub fn step(
        &mut self,
        command: MotionCommand,
        stop: StopKind,
        pivot_rad: f64,
        measured: WheelSpeeds,
        dt_s: f64,
    ) -> WheelSpeeds {
        let sane = command.is_finite() && pivot_rad.is_finite();
        let stop = if sane { stop } else { StopKind::Hard };
        let pivot_rad = if pivot_rad.is_finite() {
            pivot_rad
        } else {
            0.0
        };
        let dt_s = if dt_s.is_finite() {
            dt_s.clamp(0.0, LONGEST_STEP_S)
        } else {
            0.0
        };
        let (target_m_s, pivot_rate_rad_s) = match stop {
            StopKind::None => self.targets(command, pivot_rad),
            StopKind::Gentle | StopKind::Hard => (0.0, 0.0),
        };
        let slowing_m_s2 = match stop {
            StopKind::Hard => self.limits.stop_deceleration_m_s2,
            StopKind::None | StopKind::Gentle => self.limits.deceleration_m_s2,
        };
        if stop == StopKind::Hard && !self.stops_hard {
            self.begin_where_it_is(measured);
        }
        self.stops_hard = stop == StopKind::Hard;
        self.ramp(target_m_s, slowing_m_s2, measured, dt_s);
        let standing = target_m_s == 0.0 && self.unit_m_s.abs() < STANDING_M_S;
        if standing && pivot_rate_rad_s == 0.0 {
            self.unit_m_s = 0.0;
            return WheelSpeeds::STANDING;
        }
        self.wheels(pivot_rad, pivot_rate_rad_s)
    }

    /// Unit speed and pivot rate that the command asks for at this pivot angle.
    fn targets(&self, command: MotionCommand, pivot_rad: f64) -> (f64, f64) {
        let limit_m_s = self.limits.max_speed_m_s;
        let speed_m_s = command.speed_m_s.clamp(-limit_m_s, limit_m_s);
        let steering_rad = self.steering_for(command.curvature_1_m);
        let error_rad = wrap_angle(steering_rad - pivot_rad);
        if speed_m_s == 0.0 && self.unit_m_s.abs() < STANDING_M_S {
            // Commanded to stand: the pivot rests, because turning it would turn the platform.
            return (0.0, 0.0);
        }
        let rate_limit = self.limits.max_steering_rate_rad_s;
        let error_max_rad = self.gains.pivot_error_max_rad;
        let rate_rad_s = (self.gains.pivot_gain_1_s
            * error_rad.clamp(-error_max_rad, error_max_rad))
        .clamp(-rate_limit, rate_limit);
        // Speed of the trailing axle on that path; at the steering limit the path is the one that is possible.
        let slope = steering_rad.tan();
        let share = if error_rad.abs() > self.gains.align_rad {
            0.0
        } else {
            error_rad.cos().max(0.0)
        };
        let unit_m_s = speed_m_s * slope.hypot(1.0) * share;
        (unit_m_s, rate_rad_s)
    }

    /// A stop for a fault begins at the speed that the unit has, if that is slower than what it was told.
    fn begin_where_it_is(&mut self, measured: WheelSpeeds) {
        let measured_m_s = self.unit_speed_of(measured);
        if measured_m_s.is_finite() {
            let reach_m_s = measured_m_s.abs();
            self.unit_m_s = self.unit_m_s.clamp(-reach_m_s, reach_m_s);
        }
    }

    fn ramp(&mut self, target_m_s: f64, slowing_m_s2: f64, measured: WheelSpeeds, dt_s: f64) {
        let measured_m_s = self.unit_speed_of(measured);
        if measured_m_s.is_finite() {
            // Wheels that do not follow (motors off, blocked) must not be met by a full ramp when they are back.
            let reach_m_s = measured_m_s.abs() + RAMP_AHEAD_M_S;
            self.unit_m_s = self.unit_m_s.clamp(-reach_m_s, reach_m_s);
        }
        let slowing = self.unit_m_s * (target_m_s - self.unit_m_s) < 0.0;
        let slope_m_s2 = if slowing {
            slowing_m_s2
        } else {
            self.limits.acceleration_m_s2
        };
        let mut step_m_s = slope_m_s2 * dt_s;
        if slowing && self.unit_m_s * target_m_s < 0.0 {
            // A reversal passes through standstill.
            step_m_s = step_m_s.min(self.unit_m_s.abs());
        }
        self.unit_m_s += (target_m_s - self.unit_m_s).clamp(-step_m_s, step_m_s);
    }

    fn wheels(&mut self, pivot_rad: f64, pivot_rate_rad_s: f64) -> WheelSpeeds {
        let geometry = &self.geometry;
        let radius_m = geometry.wheel_radius_m();
        let limit_m_s = self.limits.max_wheel_speed_rad_s * radius_m;
        let twist = geometry.twist(self.unit_m_s, pivot_rad, pivot_rate_rad_s);
        let spread_m_s = ((twist.omega_rad_s + pivot_rate_rad_s) * geometry.wheel_separation_m
            / 2.0)
            .clamp(-limit_m_s, limit_m_s);
        // Steering has priority over speed when the wheels cannot do both.
        let reach_m_s = limit_m_s - spread_m_s.abs();
        self.unit_m_s = self.unit_m_s.clamp(-reach_m_s, reach_m_s);
        WheelSpeeds::new(
            (self.unit_m_s - spread_m_s) / radius_m,
            (self.unit_m_s + spread_m_s) / radius_m,
        )
        .limited(self.limits.max_wheel_speed_rad_s)
    }

    fn unit_speed_of(&self, speeds: WheelSpeeds) -> f64 {
        self.geometry.wheel_radius_m() * (speeds.left_rad_s + speeds.right_rad_s) / 2.0
    }
}

#[cfg(test)]
mod tests;
