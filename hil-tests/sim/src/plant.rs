//! The seam between a simulated drive and the world it moves in.
//!
//! The drive's bus side turns process data into a [`DriveCommand`] and asks its [`Plant`] what became of it.
//! Signs are those of the vehicle: a positive wheel speed drives the unit forward along its own heading, a
//! positive pivot angle turns it to the left (counter-clockwise). The mirrored wheel frame of the real drive
//! stays on the bus side.
//!
//! A plant is called from the thread that serves the bus, at least every 5 ms and about once per bus cycle, with
//! a monotonic time that never goes back. It must not block for long: the bus waits.

/// What the drive's electronics ask of its two motors.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct DriveCommand {
    /// The left motor is powered; otherwise its wheel only rolls out against friction.
    pub left_enabled: bool,
    /// The right motor is powered; otherwise its wheel only rolls out against friction.
    pub right_enabled: bool,
    /// Wanted speed of the left wheel, forward positive.
    pub left_rad_s: f64,
    /// Wanted speed of the right wheel, forward positive.
    pub right_rad_s: f64,
    /// Largest magnitude of the left motor's current, at least 0; it bounds the torque and so the acceleration.
    pub left_current_limit_a: f64,
    /// Largest magnitude of the right motor's current, at least 0; it bounds the torque and so the acceleration.
    pub right_current_limit_a: f64,
}

impl DriveCommand {
    /// Both motors without power: what a drive does outside OP, after a watchdog trip and in emergency stop.
    pub const OFF: DriveCommand = DriveCommand {
        left_enabled: false,
        right_enabled: false,
        left_rad_s: 0.0,
        right_rad_s: 0.0,
        left_current_limit_a: 0.0,
        right_current_limit_a: 0.0,
    };
}

/// What the drive's sensors say.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DriveFeedback {
    /// Angle of the left wheel since power-on, forward positive, not wrapped.
    pub left_rad: f64,
    /// Angle of the right wheel since power-on, forward positive, not wrapped.
    pub right_rad: f64,
    /// Speed of the left wheel, forward positive.
    pub left_rad_s: f64,
    /// Speed of the right wheel, forward positive.
    pub right_rad_s: f64,
    /// Current in the left motor, positive when it accelerates forward.
    pub left_current_a: f64,
    /// Current in the right motor, positive when it accelerates forward.
    pub right_current_a: f64,
    /// Angle of the pivot, 0 pointing forward, positive to the left; any number of turns.
    pub pivot_rad: f64,
    /// Speed of the pivot relative to the platform.
    pub pivot_rad_s: f64,
    /// Yaw rate of the platform, for the drive's gyroscope.
    pub yaw_rate_rad_s: f64,
    /// Supply voltage of the drive.
    pub bus_voltage_v: f64,
}

impl Default for DriveFeedback {
    /// At rest, pivot forward, on a 24 V supply.
    fn default() -> DriveFeedback {
        DriveFeedback {
            left_rad: 0.0,
            right_rad: 0.0,
            left_rad_s: 0.0,
            right_rad_s: 0.0,
            left_current_a: 0.0,
            right_current_a: 0.0,
            pivot_rad: 0.0,
            pivot_rad_s: 0.0,
            yaw_rate_rad_s: 0.0,
            bus_voltage_v: 24.0,
        }
    }
}

/// The mechanical side of one drive.
pub trait Plant: Send {
    /// Holds the last command up to `now_ns` (monotonic), takes `command` from there on, and returns the sensors
    /// as they are at `now_ns`.
    fn exchange(&mut self, now_ns: u64, command: &DriveCommand) -> DriveFeedback;
}

/// A drive on a test stand: both wheels spin freely, the pivot is clamped at 0.
///
/// Wheels follow the wanted speed as a first-order lag, no faster than the current limit allows.
#[derive(Debug, Clone, Default)]
pub struct TestStand {
    now_ns: u64,
    command: DriveCommand,
    feedback: DriveFeedback,
}

impl TestStand {
    /// Time constant of a wheel's speed.
    const TAU_S: f64 = 0.015;
    /// Angular acceleration per ampere.
    const ACCELERATION_RAD_S2_A: f64 = 50.0;
    /// Deceleration of a wheel without power.
    const FRICTION_RAD_S2: f64 = 30.0;
    /// Longest step of the integration.
    const STEP_S: f64 = 0.001;

    /// A drive at rest.
    #[must_use]
    pub fn new() -> TestStand {
        TestStand::default()
    }

    fn step(&mut self, dt_s: f64) {
        let (c, f) = (&self.command, &mut self.feedback);
        let left = wheel_acceleration(
            c.left_enabled,
            c.left_rad_s,
            c.left_current_limit_a,
            f.left_rad_s,
            dt_s,
        );
        let right = wheel_acceleration(
            c.right_enabled,
            c.right_rad_s,
            c.right_current_limit_a,
            f.right_rad_s,
            dt_s,
        );
        f.left_rad += (f.left_rad_s + 0.5 * left * dt_s) * dt_s;
        f.right_rad += (f.right_rad_s + 0.5 * right * dt_s) * dt_s;
        f.left_rad_s += left * dt_s;
        f.right_rad_s += right * dt_s;
        f.left_current_a = if c.left_enabled {
            left / Self::ACCELERATION_RAD_S2_A
        } else {
            0.0
        };
        f.right_current_a = if c.right_enabled {
            right / Self::ACCELERATION_RAD_S2_A
        } else {
            0.0
        };
    }
}

fn wheel_acceleration(
    enabled: bool,
    wanted_rad_s: f64,
    limit_a: f64,
    speed_rad_s: f64,
    dt_s: f64,
) -> f64 {
    if enabled {
        let share = 1.0 - (-dt_s / TestStand::TAU_S).exp();
        let bound = limit_a.max(0.0) * TestStand::ACCELERATION_RAD_S2_A;
        ((wanted_rad_s - speed_rad_s) * share / dt_s).clamp(-bound, bound)
    } else {
        let bound = TestStand::FRICTION_RAD_S2;
        (-speed_rad_s / dt_s).clamp(-bound, bound)
    }
}

impl Plant for TestStand {
    fn exchange(&mut self, now_ns: u64, command: &DriveCommand) -> DriveFeedback {
        if self.now_ns == 0 {
            self.now_ns = now_ns;
        }
        // After a second without calls the wheels have settled; a longer integration would not change the result.
        let mut left_s = (now_ns.saturating_sub(self.now_ns) as f64 * 1e-9).min(1.0);
        while left_s > 0.0 {
            let dt_s = left_s.min(Self::STEP_S);
            self.step(dt_s);
            left_s -= dt_s;
        }
        self.now_ns = self.now_ns.max(now_ns);
        self.command = *command;
        self.feedback
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const MS: u64 = 1_000_000;

    fn forward(speed_rad_s: f64, limit_a: f64) -> DriveCommand {
        DriveCommand {
            left_enabled: true,
            right_enabled: true,
            left_rad_s: speed_rad_s,
            right_rad_s: speed_rad_s,
            left_current_limit_a: limit_a,
            right_current_limit_a: limit_a,
        }
    }

    #[test]
    fn wheels_follow_and_roll_out() {
        let mut stand = TestStand::new();
        stand.exchange(MS, &forward(5.0, 20.0));
        let driving = stand.exchange(201 * MS, &DriveCommand::OFF);
        assert!((driving.left_rad_s - 5.0).abs() < 0.01, "{driving:?}");
        assert!(
            driving.left_rad > 0.8 && driving.left_rad < 1.0,
            "{driving:?}"
        );
        let rolled_out = stand.exchange(601 * MS, &DriveCommand::OFF);
        assert_eq!(rolled_out.left_rad_s, 0.0);
    }

    #[test]
    fn current_limit_bounds_acceleration() {
        let mut stand = TestStand::new();
        stand.exchange(MS, &forward(30.0, 1.0));
        let slow = stand.exchange(101 * MS, &forward(30.0, 0.0));
        assert!((slow.right_rad_s - 5.0).abs() < 0.1, "{slow:?}");
        assert!(slow.right_current_a <= 1.0 + 1e-9);
        let held = stand.exchange(201 * MS, &forward(30.0, 0.0));
        assert!((held.right_rad_s - slow.right_rad_s).abs() < 1e-9);
    }
}
