//! Up to a distance from the wall at the lane's end.

use description::robot::Navigation;

/// Closer than this counts as there when it has to stop, m.
const STOP_WITHIN_M: f64 = 0.01;
/// Slowest approach, m/s: below it the wheels do not turn evenly.
const CREEP_M_S: f64 = 0.03;

/// Slows down to the exit speed, and is done at the distance.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EndOfLane {
    /// From `base_link` to the wall, where the manoeuvre ends.
    pub distance_m: f64,
    /// Speed to have there; 0 stops there.
    pub exit_speed_m_s: f64,
}

impl EndOfLane {
    /// The speed allowed at `wall_m` from the wall, and whether it is done.
    #[must_use]
    pub fn step(
        &self,
        wall_m: f64,
        speed_limit_m_s: f64,
        speed_m_s: f64,
        gains: &Navigation,
    ) -> (f64, bool) {
        let left_m = wall_m - self.distance_m;
        let exit_m_s = self.exit_speed_m_s.min(speed_limit_m_s);
        let reachable_m_s =
            (exit_m_s * exit_m_s + 2.0 * gains.deceleration_m_s2 * left_m.max(0.0)).sqrt();
        if exit_m_s > 0.0 {
            // What follows starts with a curve, which takes the pivot its time.
            let early_m = 0.5 * gains.steering_lag_s * speed_m_s.max(0.0).min(speed_limit_m_s);
            return (reachable_m_s, left_m <= early_m);
        }
        if left_m <= STOP_WITHIN_M {
            (0.0, true)
        } else {
            (reachable_m_s.max(CREEP_M_S), false)
        }
    }
}
