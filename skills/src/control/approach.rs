//! Speeds on the way to a place where the robot must have a certain speed, or stand.

/// Delay from a command until the robot moves by it, plus the command period, s.
pub const REACTION_S: f64 = 0.12;
/// Slowest approach: below it the wheels do not turn evenly, m/s.
const CREEP_M_S: f64 = 0.03;
/// Closer than this the robot does not start again, m.
const THERE_M: f64 = 0.006;
/// Slower than this counts as standing, m/s.
const STANDING_M_S: f64 = 0.01;
/// Arrived after standing this long, s: time for some scans to confirm the place.
const SETTLED_S: f64 = 0.35;

/// The fastest speed from which `exit_m_s` can be reached within `left_m` at a constant deceleration.
#[must_use]
pub fn approach_speed_m_s(left_m: f64, exit_m_s: f64, deceleration_m_s2: f64) -> f64 {
    // While the command takes effect the robot still drives as before.
    let delay_m_s = deceleration_m_s2 * REACTION_S;
    let reachable = exit_m_s * exit_m_s + 2.0 * deceleration_m_s2 * left_m.max(0.0);
    ((reachable + delay_m_s * delay_m_s).sqrt() - delay_m_s).max(exit_m_s)
}

/// Comes to rest at a place, and says when it stands there.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Stopping {
    still_s: f64,
    arrived: bool,
}

impl Stopping {
    /// The speed for a way of `left_m` that remains (negative: past it), never negative.
    ///
    /// It moves on again while the estimate of the place still changes, until it has stood there for `SETTLED_S`.
    pub fn speed_m_s(
        &mut self,
        left_m: f64,
        speed_m_s: f64,
        deceleration_m_s2: f64,
        dt_s: f64,
    ) -> f64 {
        let there = left_m <= THERE_M;
        let still = there && speed_m_s.abs() < STANDING_M_S;
        self.still_s = if still { self.still_s + dt_s } else { 0.0 };
        self.arrived |= self.still_s >= SETTLED_S;
        if self.arrived || left_m.is_nan() || left_m <= speed_m_s.max(0.0) * REACTION_S * 0.5 {
            return 0.0;
        }
        if there && self.still_s > 0.0 {
            return 0.0;
        }
        approach_speed_m_s(left_m, 0.0, deceleration_m_s2).max(CREEP_M_S)
    }

    /// It has come to rest there; it does not move again.
    #[must_use]
    pub fn arrived(&self) -> bool {
        self.arrived
    }
}
