//! What the outputs ask of the motors, and how much of it the drive allows.

use super::injected::Injected;
use super::pdo::{Mode, Outputs, command, status};
use crate::plant::DriveCommand;

/// Highest speed of a wheel.
pub const MAX_WHEEL_RAD_S: f64 = 35.0;
/// Supply below which the motors have no power.
pub(super) const MIN_SUPPLY_V: f64 = 16.0;
/// Supply above which the motors have no power.
pub(super) const MAX_SUPPLY_V: f64 = 60.0;

/// What the outputs ask of the wheels, forward positive, before any limit of the drive.
pub(super) fn drive_command(outputs: &Outputs) -> DriveCommand {
    let [first, second] = outputs.setpoint.map(f64::from);
    let upper = outputs.upper.map(f64::from);
    let lower = outputs.lower.map(f64::from);
    // A limit that is not a number, or on the wrong side of 0, allows no current.
    let magnitude = |i: usize| upper[i].min(-lower[i]).max(0.0);
    let both = magnitude(0) + magnitude(1);
    // A current accelerates towards the speed limit on its side.
    let towards = |current_a: f64, limit_rad_s: f64| current_a.signum() * limit_rad_s;
    let (left, right, left_limit, right_limit) = match outputs.mode() {
        Mode::Velocity => (second, -first, magnitude(1), magnitude(0)),
        Mode::DifferentialVelocity => (first - second, first + second, both, both),
        Mode::Torque => (
            towards(second, magnitude(1)),
            -towards(first, magnitude(0)),
            second.abs(),
            first.abs(),
        ),
        Mode::DifferentialTorque => {
            let (left, right) = (first - second, first + second);
            (
                towards(left, both),
                towards(right, both),
                left.abs(),
                right.abs(),
            )
        }
    };
    DriveCommand {
        left_enabled: outputs.command1 & command::ENABLE_2 != 0,
        right_enabled: outputs.command1 & command::ENABLE_1 != 0,
        left_rad_s: left,
        right_rad_s: right,
        left_current_limit_a: left_limit,
        right_current_limit_a: right_limit,
    }
}

/// Takes the power from motors that must not have it.
pub(super) fn permitted(
    mut wanted: DriveCommand,
    outputs: &Outputs,
    injected: &Injected,
) -> DriveCommand {
    let stopped = |emergency, faults| {
        injected.emergency_stop
            || outputs.command1 & emergency != 0
            || injected.status1_set & faults != 0
    };
    wanted.right_enabled &= !stopped(command::EMERGENCY_1, status::FAULTS_1);
    wanted.left_enabled &= !stopped(command::EMERGENCY_2, status::FAULTS_2);
    // A setpoint that is not a number never reaches a motor.
    wanted.left_enabled &= wanted.left_rad_s.is_finite() && wanted.left_current_limit_a.is_finite();
    wanted.right_enabled &=
        wanted.right_rad_s.is_finite() && wanted.right_current_limit_a.is_finite();
    wanted
}

/// What the motors can do, and zeros for those without power.
pub(super) fn limited(wanted: DriveCommand) -> DriveCommand {
    let wheel = |enabled: bool, speed: f64, limit: f64| {
        if enabled {
            (speed.clamp(-MAX_WHEEL_RAD_S, MAX_WHEEL_RAD_S), limit)
        } else {
            (0.0, 0.0)
        }
    };
    let (left_rad_s, left_current_limit_a) = wheel(
        wanted.left_enabled,
        wanted.left_rad_s,
        wanted.left_current_limit_a,
    );
    let (right_rad_s, right_current_limit_a) = wheel(
        wanted.right_enabled,
        wanted.right_rad_s,
        wanted.right_current_limit_a,
    );
    DriveCommand {
        left_rad_s,
        right_rad_s,
        left_current_limit_a,
        right_current_limit_a,
        ..wanted
    }
}
