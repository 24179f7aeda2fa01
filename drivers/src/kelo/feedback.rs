//! What the drive reports, in the robot's terms.

use super::inputs::{Inputs, Status};

/// Wheels and pivot; left and right wheel positive when the unit drives forward along its heading.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Feedback {
    /// Left wheel angle. May jump; unwrap it.
    pub left_rad: f32,
    /// Right wheel angle. May jump; unwrap it.
    pub right_rad: f32,
    /// Left wheel speed.
    pub left_rad_s: f32,
    /// Right wheel speed.
    pub right_rad_s: f32,
    /// Pivot angle as the encoder counts it, positive to the left, wraps at ±π. The robot's configuration has its zero.
    pub pivot_rad: f32,
    /// Pivot rate.
    pub pivot_rad_s: f32,
    /// Supply voltage.
    pub bus_voltage_v: f32,
    /// Both motors are powered.
    pub enabled: bool,
}

impl From<&Inputs> for Feedback {
    fn from(inputs: &Inputs) -> Feedback {
        Feedback {
            left_rad: inputs.motor2.encoder_rad,
            right_rad: -inputs.motor1.encoder_rad,
            left_rad_s: inputs.motor2.velocity_rad_s,
            right_rad_s: -inputs.motor1.velocity_rad_s,
            pivot_rad: inputs.pivot_rad,
            pivot_rad_s: inputs.pivot_rad_s,
            bus_voltage_v: inputs.bus_voltage_v,
            enabled: inputs.status1.all(Status::ENABLED_BOTH),
        }
    }
}

#[cfg(test)]
mod tests {
    use description::wheels::WheelSpeeds;

    use super::super::{MotorInputs, Setpoint, SetpointLimits};
    use super::*;

    #[test]
    fn a_drive_that_follows_its_setpoint_reports_what_was_asked() {
        let asked = Setpoint::Speeds {
            speeds: WheelSpeeds::new(4.0, -6.0),
            current_a: 20.0,
        };
        let outputs = asked.to_outputs(&SetpointLimits::default());
        // The drive: encoder i rises when setpoint i is positive.
        let motor = |setpoint: f32| MotorInputs {
            encoder_rad: setpoint * 0.5,
            velocity_rad_s: setpoint,
            ..MotorInputs::default()
        };
        let inputs = Inputs {
            status1: Status(3),
            motor1: motor(outputs.setpoint1),
            motor2: motor(outputs.setpoint2),
            ..Inputs::default()
        };
        let feedback = Feedback::from(&inputs);
        assert_eq!((feedback.left_rad_s, feedback.right_rad_s), (4.0, -6.0));
        assert_eq!((feedback.left_rad, feedback.right_rad), (2.0, -3.0));
        assert!(feedback.enabled);
        assert!(
            !Feedback::from(&Inputs {
                status1: Status(1),
                ..inputs
            })
            .enabled
        );
    }
}
