//! One driven wheel, its motor, and what pulls at it.

/// What is wrong with a robot's wheels, or heavy on them.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Mechanics {
    /// Shares of the left and right wheel's turning that move nothing.
    pub slip: [f64; 2],
    /// What the slope of the floor does to the robot, along x and y of the world, m/s².
    pub slope_m_s2: [f64; 2],
    /// By this factor a current accelerates the robot less than its model says.
    pub load: f64,
    /// No motor slows its wheel down harder than this, at the rim, m/s².
    pub braking_m_s2: f64,
    /// The left, the right motor turns the wrong way.
    pub reversed: [bool; 2],
    /// The unit does not turn under the platform.
    pub pivot_jammed: bool,
}

impl Default for Mechanics {
    /// Everything as the model says, on level ground.
    fn default() -> Mechanics {
        Mechanics {
            slip: [0.0; 2],
            slope_m_s2: [0.0; 2],
            load: 1.0,
            braking_m_s2: f64::INFINITY,
            reversed: [false; 2],
            pivot_jammed: false,
        }
    }
}

/// What a motor can do, and its wheel without it: as [`RobotModel`](super::RobotModel) has them.
#[derive(Debug, Clone, Copy)]
pub(super) struct Motor {
    pub tau_s: f64,
    pub max_speed_rad_s: f64,
    pub acceleration_rad_s2_a: f64,
    pub friction_m_s2: f64,
}

/// What a motor is asked for.
#[derive(Debug, Clone, Copy)]
pub(super) struct Asked {
    pub enabled: bool,
    pub wanted_rad_s: f64,
    pub limit_a: f64,
}

/// One driven wheel.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Wheel {
    pub radius_m: f64,
    pub angle_rad: f64,
    pub speed_rad_s: f64,
    /// By its motor.
    pub acceleration_rad_s2: f64,
    /// Share of its turning that moves nothing.
    pub slip: f64,
}

impl Wheel {
    pub(super) fn new(radius_m: f64) -> Wheel {
        Wheel {
            radius_m,
            angle_rad: 0.0,
            speed_rad_s: 0.0,
            acceleration_rad_s2: 0.0,
            slip: 0.0,
        }
    }

    pub(super) fn rim_m_s(&self) -> f64 {
        self.speed_rad_s * self.radius_m * (1.0 - self.slip)
    }

    /// Turns as fast as its rim moves over the floor.
    pub(super) fn roll_at(&mut self, rim_m_s: f64) {
        // A wheel that only slips turns as it likes.
        if self.slip < 1.0 {
            self.speed_rad_s = rim_m_s / (self.radius_m * (1.0 - self.slip));
        }
    }

    /// One step of the motor and of what pulls at the rim, m/s².
    pub(super) fn step(
        &mut self,
        motor: &Motor,
        mechanics: &Mechanics,
        asked: Asked,
        pull_m_s2: f64,
        dt_s: f64,
    ) {
        let pull = pull_m_s2 / self.radius_m;
        let (by_motor, by_friction) = if asked.enabled {
            let bound = motor.max_speed_rad_s;
            let wanted = asked.wanted_rad_s.clamp(-bound, bound);
            // A first-order lag, exact over the step; a value that is not finite counts as 0.
            let wanted = if wanted.is_finite() { wanted } else { 0.0 };
            let share = 1.0 - (-dt_s / motor.tau_s).exp();
            let free = (wanted - self.speed_rad_s) * share / dt_s - pull;
            let mut limit = asked.limit_a.max(0.0) * motor.acceleration_rad_s2_a / mechanics.load;
            if free * self.speed_rad_s < 0.0 {
                limit = limit.min(mechanics.braking_m_s2 / self.radius_m);
            }
            (free.clamp(-limit, limit), 0.0)
        } else {
            let friction = motor.friction_m_s2 / self.radius_m;
            let held = -self.speed_rad_s / dt_s - pull;
            (0.0, held.clamp(-friction, friction))
        };
        let acceleration = by_motor + by_friction + pull;
        self.angle_rad += dt_s * (self.speed_rad_s + 0.5 * dt_s * acceleration);
        self.speed_rad_s += dt_s * acceleration;
        self.acceleration_rad_s2 = by_motor;
    }
}
