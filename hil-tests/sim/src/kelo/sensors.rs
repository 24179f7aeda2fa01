//! What the drive's sensors put into the inputs. Phase values are plausible, not measured.

use std::f64::consts::{PI, TAU};

use super::demand::MAX_SUPPLY_V;
use super::pdo::{Inputs, MotorInputs, status};
use crate::plant::{DriveCommand, DriveFeedback};

/// Supply current at rest.
const IDLE_CURRENT_A: f64 = 0.3;
const RESISTANCE_OHM: f64 = 0.3;
const BACK_EMF_V_S: f64 = 0.4;
const POLE_PAIRS: f64 = 10.0;
const TEMPERATURE_K: f32 = 303.0;
const PRESSURE_PA: f32 = 101_325.0;
const GRAVITY_M_S2: f32 = 9.81;

/// The process data inputs, but for time stamps; `zero_rad` is what the encoders (left, right) call 0.
pub(super) fn inputs(
    feedback: &DriveFeedback,
    command: &DriveCommand,
    zero_rad: (f64, f64),
) -> Inputs {
    let f = feedback;
    let mut status1 = status::ENCODERS_VALID | status::UNDERVOLTAGE;
    status1 |= if command.right_enabled {
        status::ENABLED_1
    } else {
        0
    };
    status1 |= if command.left_enabled {
        status::ENABLED_2
    } else {
        0
    };
    status1 |= if f.bus_voltage_v > MAX_SUPPLY_V {
        status::OVERVOLTAGE
    } else {
        0
    };
    let power_w = f.left_current_a
        * (f.left_rad_s * BACK_EMF_V_S + f.left_current_a * RESISTANCE_OHM)
        + f.right_current_a * (f.right_rad_s * BACK_EMF_V_S + f.right_current_a * RESISTANCE_OHM);
    Inputs {
        status1,
        status2: status::STATUS2_HEALTHY,
        motor: [
            motor(
                -(f.right_rad - zero_rad.1),
                -f.right_rad_s,
                -f.right_current_a,
            ),
            motor(f.left_rad - zero_rad.0, f.left_rad_s, f.left_current_a),
        ],
        pivot_rad: wrapped(f.pivot_rad) as f32,
        pivot_rad_s: f.pivot_rad_s as f32,
        bus_voltage_v: f.bus_voltage_v as f32,
        acceleration_m_s2: [0.0, 0.0, GRAVITY_M_S2],
        gyro_rad_s: [0.0, 0.0, f.yaw_rate_rad_s as f32],
        imu_temperature_k: TEMPERATURE_K,
        pressure_pa: PRESSURE_PA,
        input_current_a: (IDLE_CURRENT_A + power_w / f.bus_voltage_v.max(1.0)) as f32,
        ..Inputs::default()
    }
}

/// A motor in its own frame; phases follow from torque current and angle.
fn motor(encoder_rad: f64, velocity_rad_s: f64, current_a: f64) -> MotorInputs {
    let voltage_v = velocity_rad_s * BACK_EMF_V_S + current_a * RESISTANCE_OHM;
    let electrical_rad = encoder_rad * POLE_PAIRS;
    // Each phase is a third of a turn behind the one before.
    let (sin, cos) = electrical_rad.sin_cos();
    let (ahead, aside) = (-0.5 * cos, 0.75f64.sqrt() * sin);
    let shares = [cos, ahead + aside, ahead - aside];
    let phases = |amplitude: f64| shares.map(|share| (amplitude * share) as f32);
    let ([iu, iv, iw], [uu, uv, uw]) = (phases(current_a), phases(voltage_v));
    MotorInputs {
        encoder_rad: encoder_rad as f32,
        velocity_rad_s: velocity_rad_s as f32,
        current_a: [0.0, current_a as f32, iu, iv, iw],
        voltage_v: [voltage_v as f32, uu, uv, uw],
        temperature_k: TEMPERATURE_K,
    }
}

fn wrapped(angle_rad: f64) -> f64 {
    (angle_rad + PI).rem_euclid(TAU) - PI
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_pivot_wraps_at_pi() {
        assert!((wrapped(3.5 * PI) + PI / 2.0).abs() < 1e-12);
        assert!((wrapped(-3.5 * PI) - PI / 2.0).abs() < 1e-12);
        assert_eq!(wrapped(1.0), 1.0);
    }

    #[test]
    fn phase_currents_add_up_to_nothing() {
        let [d, q, u, v, w] = motor(0.37, 5.0, 8.0).current_a;
        assert_eq!((d, q), (0.0, 8.0));
        assert!((u + v + w).abs() < 1e-4);
        assert!(u.abs().max(v.abs()).max(w.abs()) <= 8.0);
    }
}
