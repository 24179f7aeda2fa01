//! The last guard on wheel setpoints: a limit, and a ramp to zero that keeps the wheels' ratio.

use crate::realtime::clock::SECOND_NS;

/// Remembers what was sent, so that a stop begins where the wheels are.
#[derive(Clone, Debug)]
pub struct WheelRamp {
    deceleration_rad_s2: f64,
    left_rad_s: f64,
    right_rad_s: f64,
    sent_ns: u64,
    moved_ns: u64,
}

impl WheelRamp {
    /// A ramp of standing wheels. `deceleration_rad_s2` is that of the faster wheel.
    #[must_use]
    pub fn new(deceleration_rad_s2: f64) -> Self {
        Self {
            deceleration_rad_s2,
            left_rad_s: 0.0,
            right_rad_s: 0.0,
            sent_ns: 0,
            moved_ns: 0,
        }
    }

    /// The wheels stand.
    pub fn reset(&mut self) {
        *self = Self::new(self.deceleration_rad_s2);
    }

    /// Takes over a setpoint, scaled down together when one wheel is over `limit_rad_s`. Not a number counts as zero.
    pub fn follow(
        &mut self,
        now_ns: u64,
        left_rad_s: f64,
        right_rad_s: f64,
        limit_rad_s: f64,
    ) -> (f64, f64) {
        let finite = left_rad_s.is_finite() && right_rad_s.is_finite();
        if !finite {
            return self.step(now_ns);
        }
        let fastest = left_rad_s.abs().max(right_rad_s.abs());
        let scale = if fastest > limit_rad_s {
            limit_rad_s / fastest
        } else {
            1.0
        };
        self.sent(now_ns, left_rad_s * scale, right_rad_s * scale)
    }

    /// One step towards standing.
    pub fn step(&mut self, now_ns: u64) -> (f64, f64) {
        let elapsed_s =
            now_ns.saturating_sub(self.sent_ns).min(SECOND_NS / 10) as f64 / SECOND_NS as f64;
        let fastest = self.left_rad_s.abs().max(self.right_rad_s.abs());
        let slower = (fastest - self.deceleration_rad_s2 * elapsed_s).max(0.0);
        let scale = if slower > 0.0 { slower / fastest } else { 0.0 };
        self.sent(now_ns, self.left_rad_s * scale, self.right_rad_s * scale)
    }

    /// How long the setpoints have been zero.
    #[must_use]
    pub fn standing_for(&self, now_ns: u64) -> u64 {
        now_ns.saturating_sub(self.moved_ns)
    }

    fn sent(&mut self, now_ns: u64, left_rad_s: f64, right_rad_s: f64) -> (f64, f64) {
        (self.left_rad_s, self.right_rad_s, self.sent_ns) = (left_rad_s, right_rad_s, now_ns);
        if left_rad_s != 0.0 || right_rad_s != 0.0 {
            self.moved_ns = now_ns;
        }
        (left_rad_s, right_rad_s)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const MS: u64 = 1_000_000;

    #[test]
    fn a_stop_begins_at_the_last_setpoint_and_ends_at_zero() {
        let mut ramp = WheelRamp::new(40.0);
        assert_eq!(ramp.follow(MS, 8.0, 4.0, 35.0), (8.0, 4.0));
        let mut last = (8.0, 4.0);
        for cycle in 2..=201 {
            let now = ramp.step(cycle * MS);
            assert!(
                (now.0 - (last.0 - 0.04)).abs() < 1e-9 && (now.0 - 2.0 * now.1).abs() < 1e-9,
                "{now:?}"
            );
            last = now;
        }
        assert_eq!(ramp.step(202 * MS), (0.0, 0.0));
    }

    #[test]
    fn what_is_not_a_number_stops_the_wheels() {
        let mut ramp = WheelRamp::new(40.0);
        ramp.follow(MS, 1.0, 1.0, 35.0);
        assert_eq!(ramp.follow(100 * MS, f64::NAN, 1.0, 35.0), (0.0, 0.0));
    }

    proptest! {
        #[test]
        fn no_wheel_is_ever_over_the_limit(
            setpoints in prop::collection::vec((-1e6_f64..1e6, -1e6_f64..1e6, any::<bool>()), 1..50)
        ) {
            let mut ramp = WheelRamp::new(40.0);
            for (cycle, (left, right, stop)) in setpoints.into_iter().enumerate() {
                let now_ns = cycle as u64 * MS;
                let (l, r) = if stop { ramp.step(now_ns) } else { ramp.follow(now_ns, left, right, 35.0) };
                prop_assert!(l.abs() <= 35.0 + 1e-9 && r.abs() <= 35.0 + 1e-9);
            }
        }
    }
}
