//! Faults of the drive itself, and a record of the setpoints it received.

use std::sync::{Arc, Mutex, PoisonError};

use super::demand::{MAX_WHEEL_RAD_S, drive_command};
use super::injected::Injected;
use super::pdo::{Mode, Outputs, command};

/// Injects faults into one drive and tells which setpoints it received; can be cloned and used from any thread.
#[derive(Debug, Clone, Default)]
pub struct DriveHandle(Arc<Mutex<Shared>>);

#[derive(Debug, Default)]
struct Shared {
    injected: Injected,
    statistics: DriveStatistics,
}

/// Smallest and largest value seen; both 0 before the first.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Extremes {
    /// Smallest.
    pub min: f64,
    /// Largest.
    pub max: f64,
}

impl Extremes {
    /// Largest magnitude.
    #[must_use]
    pub fn magnitude(&self) -> f64 {
        self.max.max(-self.min)
    }

    fn include(&mut self, value: f64) {
        self.min = self.min.min(value);
        self.max = self.max.max(value);
    }
}

/// The setpoints that a drive received in OP, exactly as they came, whether motors were enabled or not.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct DriveStatistics {
    /// Complete writes of the outputs.
    pub setpoints: u64,
    /// Writes with both motors enabled.
    pub enabled: u64,
    /// Speeds asked of the left wheel in the velocity modes, forward positive, rad/s.
    pub left_rad_s: Extremes,
    /// Speeds asked of the right wheel in the velocity modes, forward positive, rad/s.
    pub right_rad_s: Extremes,
    /// Largest current limit in the velocity modes, or current in the torque modes, A.
    pub max_current_a: f64,
    /// Writes in which a setpoint or limit was not finite.
    pub not_finite: u64,
    /// Writes that asked a wheel for more than the drive's 35 rad/s.
    pub over_speed: u64,
    /// Writes in a torque mode.
    pub torque: u64,
    /// Writes with an emergency bit.
    pub emergency: u64,
    /// The last speeds asked of left and right wheel in the velocity modes, rad/s.
    pub last_rad_s: (f64, f64),
    /// The last `command1`.
    pub last_command1: u16,
}

impl DriveHandle {
    /// The setpoints received so far.
    #[must_use]
    pub fn statistics(&self) -> DriveStatistics {
        self.with(|shared| shared.statistics)
    }

    /// Clears the record.
    pub fn reset_statistics(&self) {
        self.with(|shared| shared.statistics = DriveStatistics::default());
    }

    /// Replaces the supply voltage, or gives it back to the plant. Below 16 V and above 60 V motors have no power.
    pub fn set_bus_voltage(&self, volts: Option<f64>) {
        self.with(|shared| shared.injected.bus_voltage_v = volts);
    }

    /// Sets and clears bits of `status1`; 0 and 0 end it. Overcurrent and overtemperature take the power from their
    /// motor.
    pub fn set_status1_bits(&self, set: u16, cleared: u16) {
        self.with(|shared| {
            shared.injected.status1_set = set;
            shared.injected.status1_cleared = cleared;
        });
    }

    /// Replaces `status2`, or gives it back to the drive.
    pub fn set_status2(&self, value: Option<u16>) {
        self.with(|shared| shared.injected.status2 = value);
    }

    /// Presses or releases the emergency stop button: both motors lose their power.
    pub fn set_emergency_stop(&self, pressed: bool) {
        self.with(|shared| shared.injected.emergency_stop = pressed);
    }

    /// Freezes the sensors, their time stamps included.
    pub fn freeze_sensors(&self, frozen: bool) {
        self.with(|shared| shared.injected.sensors_frozen = frozen);
    }

    /// The wheels' encoders have counted this much farther, as after days; until the drive loses its power. To be said before the
    /// drive is first asked.
    pub fn set_encoders_ahead(&self, ahead_rad: f64) {
        self.with(|shared| shared.injected.encoders_ahead_rad = ahead_rad);
    }

    /// The left wheel's encoder stands still, or counts on from where the wheel is then.
    pub fn stick_left_encoder(&self, stuck: bool) {
        self.with(|shared| shared.injected.encoder_stuck[0] = stuck);
    }

    /// The same of the right wheel's.
    pub fn stick_right_encoder(&self, stuck: bool) {
        self.with(|shared| shared.injected.encoder_stuck[1] = stuck);
    }

    /// The same of the pivot's.
    pub fn stick_pivot_encoder(&self, stuck: bool) {
        self.with(|shared| shared.injected.encoder_stuck[2] = stuck);
    }

    /// Ends every injected fault.
    pub fn clear_faults(&self) {
        self.with(|shared| {
            // How far it has driven is no fault.
            let encoders_ahead_rad = shared.injected.encoders_ahead_rad;
            shared.injected = Injected {
                encoders_ahead_rad,
                ..Injected::default()
            };
        });
    }

    pub(super) fn injected(&self) -> Injected {
        self.with(|shared| shared.injected)
    }

    /// Takes note of outputs that were written.
    pub(super) fn record(&self, outputs: &Outputs) {
        let wanted = drive_command(outputs);
        let speeds = [wanted.left_rad_s, wanted.right_rad_s];
        let currents = [wanted.left_current_limit_a, wanted.right_current_limit_a];
        let raw = [outputs.setpoint, outputs.upper, outputs.lower];
        self.with(|shared| {
            let s = &mut shared.statistics;
            s.setpoints += 1;
            s.enabled += u64::from(wanted.left_enabled && wanted.right_enabled);
            s.emergency +=
                u64::from(outputs.command1 & (command::EMERGENCY_1 | command::EMERGENCY_2) != 0);
            s.last_command1 = outputs.command1;
            if raw.iter().flatten().any(|value| !value.is_finite()) {
                s.not_finite += 1;
                return;
            }
            s.max_current_a = currents.into_iter().fold(s.max_current_a, f64::max);
            match outputs.mode() {
                Mode::Velocity | Mode::DifferentialVelocity => {
                    s.left_rad_s.include(speeds[0]);
                    s.right_rad_s.include(speeds[1]);
                    s.last_rad_s = (speeds[0], speeds[1]);
                    s.over_speed +=
                        u64::from(speeds.iter().any(|speed| speed.abs() > MAX_WHEEL_RAD_S));
                }
                Mode::Torque | Mode::DifferentialTorque => s.torque += 1,
            }
        });
    }

    fn with<R>(&self, use_it: impl FnOnce(&mut Shared) -> R) -> R {
        use_it(&mut self.0.lock().unwrap_or_else(PoisonError::into_inner))
    }
}
