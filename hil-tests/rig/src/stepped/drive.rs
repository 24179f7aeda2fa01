//! Stands in for the drive activity: setpoints go to the world's wheels every cycle, encoder values come back.

use coordination::symbols::{Reader, Writer};
use description::wheels::{EncoderAngles, WheelSpeeds};
use onboard::activities::drive::Settings;
use onboard::symbols::values::{DriveStatus, Encoders, WheelSetpoints};
use onboard::symbols::wiring::DriveSymbols;
use sim::plant::DriveCommand;
use sim::world::World;

/// One robot's drive, in operation from the first cycle on.
pub(super) struct SteppedDrive {
    robot: usize,
    settings: Settings,
    setpoints: Reader<WheelSetpoints>,
    encoders: Writer<Encoders>,
    status: Writer<DriveStatus>,
    cycles: u64,
}

impl SteppedDrive {
    pub(super) fn new(robot: usize, settings: Settings, symbols: DriveSymbols) -> Self {
        Self {
            robot,
            settings,
            setpoints: symbols.setpoints,
            encoders: symbols.encoders,
            status: symbols.status,
            cycles: 0,
        }
    }

    /// One exchange. Numbers cross the bus as the process data has them, in single precision.
    pub(super) fn cycle(&mut self, world: &mut World, now_ns: u64) {
        let wanted = self.setpoints.read();
        let age_ns = now_ns.saturating_sub(wanted.stamp_ns);
        // Here nothing is late but the first setpoint.
        let stale = wanted.stamp_ns == 0 || age_ns > self.settings.setpoint_timeout_ns;
        let speeds = if stale {
            WheelSpeeds::STANDING
        } else {
            wanted
                .value
                .speeds
                .limited(self.settings.max_wheel_speed_rad_s)
        };
        let current_a = if speeds == WheelSpeeds::STANDING {
            self.settings.stop_current_a
        } else {
            self.settings.drive_current_a
        };
        let command = DriveCommand {
            left_enabled: true,
            right_enabled: true,
            left_rad_s: f64::from(speeds.left_rad_s as f32),
            right_rad_s: f64::from(speeds.right_rad_s as f32),
            left_current_limit_a: f64::from(current_a),
            right_current_limit_a: f64::from(current_a),
        };
        let feedback = world.exchange(self.robot, now_ns, &command);
        let narrow = |value: f64| f64::from(value as f32);
        self.encoders.write(
            now_ns,
            &Encoders {
                angles: EncoderAngles {
                    left_rad: narrow(feedback.left_rad),
                    right_rad: narrow(feedback.right_rad),
                    pivot_rad: narrow(feedback.pivot_rad) - self.settings.pivot_zero_rad,
                },
                speeds: WheelSpeeds::new(narrow(feedback.left_rad_s), narrow(feedback.right_rad_s)),
                pivot_rad_s: narrow(feedback.pivot_rad_s),
                epoch: 1,
            },
        );
        self.cycles += 1;
        let status = DriveStatus {
            operational: 1,
            follows: 1,
            cycles: self.cycles,
            bring_ups: 1,
            bus_voltage_v: feedback.bus_voltage_v,
            sent_left_rad_s: speeds.left_rad_s,
            sent_right_rad_s: speeds.right_rad_s,
            ..DriveStatus::default()
        };
        self.status.write(now_ns, &status);
    }
}
