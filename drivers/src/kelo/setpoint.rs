//! Wheel speeds in the robot's terms, converted to the process data of the drive.

use description::wheels::WheelSpeeds;

use super::outputs::{CommandWord, Mode, Outputs};
use super::{MAX_WHEEL_SPEED_RAD_S, MIN_WHEEL_SPEED_RAD_S};

/// What the two wheels are to do.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum Setpoint {
    /// Motors off: the wheels roll freely.
    #[default]
    Off,
    /// Turn at these speeds. Zero holds still with force.
    Speeds {
        /// Of both wheels.
        speeds: WheelSpeeds,
        /// At most this current in each motor, either way.
        current_a: f32,
    },
    /// Emergency stop by the drive itself: emergency bits set, speed setpoints zero.
    Emergency {
        /// At most this current in each motor, either way.
        current_a: f32,
    },
}

/// Limits on what is sent to the drive, whatever the setpoint.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SetpointLimits {
    /// Highest wheel speed. Never above [`MAX_WHEEL_SPEED_RAD_S`].
    pub max_wheel_speed_rad_s: f32,
    /// Highest current limit of each motor.
    pub max_current_a: f32,
}

impl Default for SetpointLimits {
    /// What the vendor's own driver allows.
    fn default() -> SetpointLimits {
        SetpointLimits {
            max_wheel_speed_rad_s: MAX_WHEEL_SPEED_RAD_S,
            max_current_a: 20.0,
        }
    }
}

impl Setpoint {
    /// The process data for this setpoint. Wheel speeds are scaled down together to the limit; speeds too slow to turn
    /// a wheel, and NaN, become zero.
    #[must_use]
    pub fn to_outputs(self, limits: &SetpointLimits) -> Outputs {
        const BOTH: u16 = CommandWord::ENABLE_1 | CommandWord::ENABLE_2;
        const EMERGENCY: u16 = CommandWord::EMERGENCY_1 | CommandWord::EMERGENCY_2;
        let velocity = CommandWord::off().in_mode(Mode::Velocity);
        let (bits, speeds, current_a) = match self {
            Setpoint::Off => {
                return Outputs {
                    command1: velocity,
                    ..Outputs::default()
                };
            }
            Setpoint::Speeds { speeds, current_a } => (BOTH, speeds, current_a),
            Setpoint::Emergency { current_a } => {
                (BOTH | EMERGENCY, WheelSpeeds::STANDING, current_a)
            }
        };
        let limit_rad_s = at_most(limits.max_wheel_speed_rad_s, MAX_WHEEL_SPEED_RAD_S);
        let speeds = speeds.limited(f64::from(limit_rad_s));
        let current_a = at_most(current_a, limits.max_current_a);
        Outputs {
            command1: velocity.with(bits),
            // Motor 1 is the right wheel, mirrored. Adding zero turns -0 into 0.
            setpoint1: -turning(speeds.right_rad_s) + 0.0,
            setpoint2: turning(speeds.left_rad_s) + 0.0,
            limit1_p: current_a,
            limit1_n: -current_a,
            limit2_p: current_a,
            limit2_n: -current_a,
            ..Outputs::default()
        }
    }
}

/// The speed as the process data has it; zero for one that is too slow to turn the wheel.
fn turning(rad_s: f64) -> f32 {
    let rad_s = rad_s as f32;
    if rad_s.abs() >= MIN_WHEEL_SPEED_RAD_S {
        rad_s
    } else {
        0.0
    }
}

/// `value` clamped to zero and `limit`; NaN becomes zero.
fn at_most(value: f32, limit: f32) -> f32 {
    if value > 0.0 && limit > 0.0 {
        value.min(limit)
    } else {
        0.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn outputs(left_rad_s: f32, right_rad_s: f32, current_a: f32) -> Outputs {
        Setpoint::Speeds {
            speeds: WheelSpeeds::new(f64::from(left_rad_s), f64::from(right_rad_s)),
            current_a,
        }
        .to_outputs(&SetpointLimits::default())
    }

    #[test]
    fn forward_turns_motor_1_negative_and_motor_2_positive() {
        let forward = outputs(3.0, 2.0, 20.0);
        assert_eq!((forward.setpoint1, forward.setpoint2), (-2.0, 3.0));
        assert_eq!(
            forward.command1.0, 0x000B,
            "velocity mode, both motors enabled"
        );
        assert_eq!(
            (
                forward.limit1_p,
                forward.limit1_n,
                forward.limit2_p,
                forward.limit2_n
            ),
            (20.0, -20.0, 20.0, -20.0)
        );
        assert_eq!((forward.command2, forward.timestamp_ns), (0, 0));
    }

    #[test]
    fn speeds_are_clipped_and_crawling_is_standing() {
        for (asked, told) in [
            (34.9, 34.9),
            (35.0, 35.0),
            (35.1, 35.0),
            (-1e9, -35.0),
            (f32::INFINITY, 35.0),
            (0.01, 0.01),
            (-0.01, -0.01),
            (0.009_99, 0.0),
            (-0.009_99, 0.0),
            (f32::NAN, 0.0),
        ] {
            assert_eq!(outputs(asked, 0.0, 1.0).setpoint2, told, "left {asked}");
            assert_eq!(outputs(0.0, asked, 1.0).setpoint1, -told, "right {asked}");
        }
        assert!(
            outputs(0.0, 0.0, 1.0).setpoint1.is_sign_positive(),
            "no negative zero on the wire"
        );
    }

    #[test]
    fn limits_of_the_caller_are_kept_but_never_widen_the_drives() {
        let setpoint = Setpoint::Speeds {
            speeds: WheelSpeeds::new(50.0, -50.0),
            current_a: 50.0,
        };
        let narrow = setpoint.to_outputs(&SetpointLimits {
            max_wheel_speed_rad_s: 8.0,
            max_current_a: 5.0,
        });
        assert_eq!(
            (narrow.setpoint1, narrow.setpoint2, narrow.limit1_p),
            (8.0, 8.0, 5.0)
        );
        let wide = setpoint.to_outputs(&SetpointLimits {
            max_wheel_speed_rad_s: 80.0,
            max_current_a: 30.0,
        });
        assert_eq!(
            (wide.setpoint1, wide.setpoint2, wide.limit1_p),
            (35.0, 35.0, 30.0)
        );
    }

    #[test]
    fn off_and_emergency() {
        let off = Setpoint::Off.to_outputs(&SetpointLimits::default());
        assert!(
            !off.command1
                .has(CommandWord::ENABLE_1 | CommandWord::ENABLE_2)
        );
        assert_eq!(
            (off.setpoint1, off.setpoint2, off.limit1_p),
            (0.0, 0.0, 0.0)
        );
        let emergency =
            Setpoint::Emergency { current_a: 1.0 }.to_outputs(&SetpointLimits::default());
        assert_eq!(emergency.command1.0, 0x003B);
        assert_eq!(
            (emergency.setpoint1, emergency.setpoint2, emergency.limit2_n),
            (0.0, 0.0, -1.0)
        );
    }

    proptest! {
        #[test]
        fn whatever_is_asked_stays_in_bounds(left: f32, right: f32, current: f32, max_speed: f32, max_current: f32) {
            let setpoint = Setpoint::Speeds { speeds: WheelSpeeds::new(f64::from(left), f64::from(right)), current_a: current };
            let limits = SetpointLimits { max_wheel_speed_rad_s: max_speed, max_current_a: max_current };
            let outputs = setpoint.to_outputs(&limits);
            for speed in [outputs.setpoint1, outputs.setpoint2] {
                prop_assert!(speed.abs() <= MAX_WHEEL_SPEED_RAD_S);
            }
            prop_assert!(outputs.limit1_p >= 0.0 && outputs.limit1_n == -outputs.limit1_p);
        }
    }
}
