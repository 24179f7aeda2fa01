//! One robot's body: a tricycle whose front unit steers by the difference of its two wheels, with caster.
//!
//! With the unit's axle a distance s behind its pivot, the axle's speed v_u along the unit and the unit's own rate
//! of turn Ω = (v_right − v_left) / separation, the pivot at (L, 0) moves as the platform does:
//! v = v_u·cos δ − s·Ω·sin δ and ω·L = v_u·sin δ + s·Ω·cos δ, and the pivot angle changes by δ' = Ω − ω.

use super::error::WorldError;
use super::geometry::{Footprint, Pose, Twist};
use super::random::Random;
use super::wheel::{Asked, Mechanics, Motor, Wheel};
use crate::plant::{DriveCommand, DriveFeedback};

/// What a robot is made of. [`RobotModel::new`] gives a complete one; change what differs.
#[derive(Debug, Clone, PartialEq)]
pub struct RobotModel {
    /// Name, unique in the world.
    pub id: String,
    /// Where `base_link` starts.
    pub start: Pose,
    /// The pivot angle it starts with.
    pub start_pivot_rad: f64,
    /// The true outline.
    pub footprint: Footprint,
    /// From `base_link`, the middle of the fixed axle, to the pivot.
    pub wheelbase_m: f64,
    /// Nominal diameter of the driven wheels.
    pub wheel_diameter_m: f64,
    /// Between the two driven wheels.
    pub wheel_separation_m: f64,
    /// From the pivot back to the axle of the driven wheels.
    pub caster_offset_m: f64,
    /// What the pivot encoder reads when the unit points forward.
    pub pivot_zero_rad: f64,
    /// Where the lidar is mounted, in `base_link`.
    pub lidar: Pose,
    /// Largest relative error of a wheel's radius; each wheel draws its own from the seed.
    pub wheel_scale_error: f64,
    /// Time constant of a wheel's speed.
    pub wheel_tau_s: f64,
    /// What the drive's electronics clip wanted speeds to.
    pub max_wheel_speed_rad_s: f64,
    /// Angular acceleration of a wheel per ampere.
    pub acceleration_rad_s2_a: f64,
    /// Deceleration at the rim of a wheel without power.
    pub friction_m_s2: f64,
    /// Supply voltage.
    pub bus_voltage_v: f64,
}

impl RobotModel {
    /// The reference platform (0.40 m × 0.30 m, one KELO drive) at a start pose.
    pub fn new(id: impl Into<String>, start: Pose) -> RobotModel {
        RobotModel {
            id: id.into(),
            start,
            start_pivot_rad: 0.0,
            footprint: Footprint {
                front_m: 0.32,
                rear_m: 0.08,
                left_m: 0.15,
                right_m: 0.15,
            },
            wheelbase_m: 0.25,
            wheel_diameter_m: 0.105,
            wheel_separation_m: 0.0775,
            caster_offset_m: 0.01,
            pivot_zero_rad: 0.0,
            lidar: Pose::new(0.28, 0.0, 0.0),
            wheel_scale_error: 0.01,
            wheel_tau_s: 0.015,
            max_wheel_speed_rad_s: 35.0,
            acceleration_rad_s2_a: 50.0,
            friction_m_s2: 1.5,
            bus_voltage_v: 24.0,
        }
    }

    pub(super) fn check(&self) -> Result<(), WorldError> {
        let f = &self.footprint;
        let positive = [
            ("wheelbase_m", self.wheelbase_m),
            ("wheel_diameter_m", self.wheel_diameter_m),
            ("wheel_separation_m", self.wheel_separation_m),
            ("wheel_tau_s", self.wheel_tau_s),
            ("max_wheel_speed_rad_s", self.max_wheel_speed_rad_s),
            ("acceleration_rad_s2_a", self.acceleration_rad_s2_a),
            ("friction_m_s2", self.friction_m_s2),
            ("footprint length", f.front_m + f.rear_m),
            ("footprint width", f.left_m + f.right_m),
        ];
        for (what, value) in positive {
            if !(value.is_finite() && value > 0.0) {
                return Err(self.error(format!("{what} = {value}, expected a positive number")));
            }
        }
        let finite = [
            ("start", self.start.is_finite()),
            ("lidar", self.lidar.is_finite()),
            ("start_pivot_rad", self.start_pivot_rad.is_finite()),
            ("pivot_zero_rad", self.pivot_zero_rad.is_finite()),
            ("caster_offset_m", self.caster_offset_m.is_finite()),
            ("bus_voltage_v", self.bus_voltage_v.is_finite()),
            ("footprint", f.reach_m().is_finite()),
        ];
        for (what, is_finite) in finite {
            if !is_finite {
                return Err(self.error(format!("{what} is not finite")));
            }
        }
        if !(0.0..1.0).contains(&self.wheel_scale_error) {
            return Err(self.error(format!(
                "wheel_scale_error = {}, expected 0 to 1",
                self.wheel_scale_error
            )));
        }
        Ok(())
    }

    fn motor(&self) -> Motor {
        Motor {
            tau_s: self.wheel_tau_s,
            max_speed_rad_s: self.max_wheel_speed_rad_s,
            acceleration_rad_s2_a: self.acceleration_rad_s2_a,
            friction_m_s2: self.friction_m_s2,
        }
    }

    fn error(&self, reason: String) -> WorldError {
        WorldError::Robot {
            id: self.id.clone(),
            reason,
        }
    }
}

/// What changes when a robot moves.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Motion {
    pub(super) pose: Pose,
    pub(super) twist: Twist,
    pub(super) pivot_rad: f64,
    pub(super) pivot_rad_s: f64,
    left: Wheel,
    right: Wheel,
    pub(super) mechanics: Mechanics,
}

impl Motion {
    pub(super) fn new(model: &RobotModel, random: &mut Random) -> Motion {
        let nominal_m = 0.5 * model.wheel_diameter_m;
        let mut wheel =
            || Wheel::new(nominal_m * (1.0 + random.symmetric(model.wheel_scale_error)));
        Motion {
            pose: model.start,
            twist: Twist::default(),
            pivot_rad: model.start_pivot_rad,
            pivot_rad_s: 0.0,
            left: wheel(),
            right: wheel(),
            mechanics: Mechanics::default(),
        }
    }

    /// The state `dt_s` later.
    pub(super) fn stepped(&self, model: &RobotModel, command: &DriveCommand, dt_s: f64) -> Motion {
        let mut next = *self;
        let mechanics = &self.mechanics;
        let pull_m_s2 = match mechanics.slope_m_s2 {
            [0.0, 0.0] => 0.0,
            [along_x, along_y] => {
                let (sin, cos) = (self.pose.theta_rad + self.pivot_rad).sin_cos();
                along_x * cos + along_y * sin
            }
        };
        let turned = |reversed: bool, wanted: f64| if reversed { -wanted } else { wanted };
        let [left, right] = mechanics.reversed;
        let left = Asked {
            enabled: command.left_enabled,
            wanted_rad_s: turned(left, command.left_rad_s),
            limit_a: command.left_current_limit_a,
        };
        let right = Asked {
            enabled: command.right_enabled,
            wanted_rad_s: turned(right, command.right_rad_s),
            limit_a: command.right_current_limit_a,
        };
        let motor = model.motor();
        next.left.step(&motor, mechanics, left, pull_m_s2, dt_s);
        next.right.step(&motor, mechanics, right, pull_m_s2, dt_s);
        if mechanics.pivot_jammed {
            next.jam(model);
        }
        // Midpoint rule: speeds and angles of the middle of the step carry the pose over the whole step.
        let left_m_s = 0.5 * (self.left.rim_m_s() + next.left.rim_m_s());
        let right_m_s = 0.5 * (self.right.rim_m_s() + next.right.rim_m_s());
        let half_s = 0.5 * dt_s;
        let (_, pivot_rad_s) = velocities(model, self.pivot_rad, left_m_s, right_m_s);
        let middle_rad = self.pivot_rad + half_s * pivot_rad_s;
        let (twist, pivot_rad_s) = velocities(model, middle_rad, left_m_s, right_m_s);
        let heading = self.pose.theta_rad + half_s * twist.omega_rad_s;
        next.pose.x_m += dt_s * twist.v_m_s * heading.cos();
        next.pose.y_m += dt_s * twist.v_m_s * heading.sin();
        next.pose.theta_rad += dt_s * twist.omega_rad_s;
        next.pivot_rad += dt_s * pivot_rad_s;
        (next.twist, next.pivot_rad_s) = velocities(
            model,
            next.pivot_rad,
            next.left.rim_m_s(),
            next.right.rim_m_s(),
        );
        next
    }

    /// The same time with the platform held by what it ran into: the unit does not advance but may still turn.
    pub(super) fn blocked(&self, before: &Motion, model: &RobotModel, dt_s: f64) -> Motion {
        let common = 0.5 * (self.left.rim_m_s() + self.right.rim_m_s());
        let mut held = *self;
        held.left.speed_rad_s -= common / held.left.radius_m;
        held.right.speed_rad_s -= common / held.right.radius_m;
        held.pose = before.pose;
        held.twist = Twist::default();
        held.pivot_rad_s = (held.right.rim_m_s() - held.left.rim_m_s()) / model.wheel_separation_m;
        held.pivot_rad = before.pivot_rad + dt_s * held.pivot_rad_s;
        held
    }

    /// What the drive's sensors read `ahead_s` after this state, at constant speed.
    pub(super) fn feedback(&self, model: &RobotModel, ahead_s: f64) -> DriveFeedback {
        DriveFeedback {
            left_rad: self.left.angle_rad + ahead_s * self.left.speed_rad_s,
            right_rad: self.right.angle_rad + ahead_s * self.right.speed_rad_s,
            left_rad_s: self.left.speed_rad_s,
            right_rad_s: self.right.speed_rad_s,
            left_current_a: self.left.acceleration_rad_s2 / model.acceleration_rad_s2_a,
            right_current_a: self.right.acceleration_rad_s2 / model.acceleration_rad_s2_a,
            pivot_rad: self.pivot_rad + ahead_s * self.pivot_rad_s + model.pivot_zero_rad,
            pivot_rad_s: self.pivot_rad_s,
            yaw_rate_rad_s: self.twist.omega_rad_s,
            bus_voltage_v: model.bus_voltage_v,
        }
    }

    /// Where the platform is `ahead_s` after this state, at constant speed.
    pub(super) fn pose_ahead(&self, ahead_s: f64) -> Pose {
        let heading = self.pose.theta_rad + 0.5 * ahead_s * self.twist.omega_rad_s;
        Pose::new(
            self.pose.x_m + ahead_s * self.twist.v_m_s * heading.cos(),
            self.pose.y_m + ahead_s * self.twist.v_m_s * heading.sin(),
            self.pose.theta_rad + ahead_s * self.twist.omega_rad_s,
        )
    }

    /// At rest at a pose, with the wheels as they are turned.
    pub(super) fn set_down(&mut self, pose: Pose) {
        (self.pose, self.twist, self.pivot_rad_s) = (pose, Twist::default(), 0.0);
        for wheel in [&mut self.left, &mut self.right] {
            (wheel.speed_rad_s, wheel.acceleration_rad_s2) = (0.0, 0.0);
        }
    }

    /// From now on its wheels are like this.
    pub(super) fn wear(&mut self, mechanics: Mechanics) {
        [self.left.slip, self.right.slip] = mechanics.slip.map(|share| share.clamp(0.0, 1.0));
        self.mechanics = mechanics;
    }

    /// Has the wheels turn only as a unit does that cannot turn under the platform: δ' = 0, so Ω = ω.
    fn jam(&mut self, model: &RobotModel) {
        let (sin, cos) = self.pivot_rad.sin_cos();
        let unit_m_s = 0.5 * (self.left.rim_m_s() + self.right.rim_m_s());
        let omega_rad_s = unit_m_s * sin / (model.wheelbase_m - model.caster_offset_m * cos);
        let spread_m_s = 0.5 * omega_rad_s * model.wheel_separation_m;
        self.left.roll_at(unit_m_s - spread_m_s);
        self.right.roll_at(unit_m_s + spread_m_s);
    }

    /// True radii of the left and right wheel.
    pub(super) fn wheel_radii_m(&self) -> [f64; 2] {
        [self.left.radius_m, self.right.radius_m]
    }
}

fn velocities(model: &RobotModel, pivot_rad: f64, left_m_s: f64, right_m_s: f64) -> (Twist, f64) {
    let (sin, cos) = pivot_rad.sin_cos();
    let unit_m_s = 0.5 * (left_m_s + right_m_s);
    let unit_rad_s = (right_m_s - left_m_s) / model.wheel_separation_m;
    let swing_m_s = model.caster_offset_m * unit_rad_s;
    let omega_rad_s = (unit_m_s * sin + swing_m_s * cos) / model.wheelbase_m;
    let v_m_s = unit_m_s * cos - swing_m_s * sin;
    (Twist { v_m_s, omega_rad_s }, unit_rad_s - omega_rad_s)
}
