//! The last guard on wheel setpoints: a limit, and a ramp to zero that keeps the wheels' ratio.

use description::wheels::WheelSpeeds;

use crate::realtime::clock::SECOND_NS;

/// Remembers what was sent, so that a stop begins where the wheels are.
#[derive(Clone, Debug)]
pub struct WheelRamp {
    deceleration_rad_s2: f64,
    last: WheelSpeeds,
    sent_ns: u64,
    moved_ns: u64,
    stops: bool,
}

impl WheelRamp {
    /// A ramp of standing wheels. `deceleration_rad_s2` is that of the faster wheel.
    #[must_use]
    pub fn new(deceleration_rad_s2: f64) -> Self {
        Self {
            deceleration_rad_s2,
            last: WheelSpeeds::STANDING,
            sent_ns: 0,
            moved_ns: 0,
            stops: false,
        }
    }

    /// The wheels stand.
    pub fn reset(&mut self) {
        *self = Self::new(self.deceleration_rad_s2);
    }

    /// Takes over a setpoint, within `limit_rad_s`. What is not finite is a step towards standing.
    pub fn follow(&mut self, now_ns: u64, wanted: WheelSpeeds, limit_rad_s: f64) -> WheelSpeeds {
        if !wanted.is_finite() {
            return self.step(now_ns);
        }
        self.stops = false;
        self.sent(now_ns, wanted.limited(limit_rad_s))
    }

    /// One step towards standing, of wheels that turn at `found`: a stop begins where they are, if that is slower than what they
    /// were told.
    pub fn stop(&mut self, now_ns: u64, found: WheelSpeeds) -> WheelSpeeds {
        let (told_rad_s, found_rad_s) = (self.last.fastest_rad_s(), found.fastest_rad_s());
        if !self.stops && found_rad_s < told_rad_s {
            self.last = self.last.scaled(found_rad_s / told_rad_s);
        }
        self.stops = true;
        self.step(now_ns)
    }

    /// One step towards standing.
    fn step(&mut self, now_ns: u64) -> WheelSpeeds {
        let elapsed_s =
            now_ns.saturating_sub(self.sent_ns).min(SECOND_NS / 10) as f64 / SECOND_NS as f64;
        let fastest_rad_s = self.last.fastest_rad_s();
        let slower_rad_s = (fastest_rad_s - self.deceleration_rad_s2 * elapsed_s).max(0.0);
        let share = if slower_rad_s > 0.0 {
            slower_rad_s / fastest_rad_s
        } else {
            0.0
        };
        self.sent(now_ns, self.last.scaled(share))
    }

    /// How long the setpoints have been zero.
    #[must_use]
    pub fn standing_for(&self, now_ns: u64) -> u64 {
        now_ns.saturating_sub(self.moved_ns)
    }

    fn sent(&mut self, now_ns: u64, speeds: WheelSpeeds) -> WheelSpeeds {
        (self.last, self.sent_ns) = (speeds, now_ns);
        if speeds != WheelSpeeds::STANDING {
            self.moved_ns = now_ns;
        }
        speeds
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
        let mut last = WheelSpeeds::new(8.0, 4.0);
        assert_eq!(ramp.follow(MS, last, 35.0), last);
        for cycle in 2..=201 {
            let now = ramp.stop(cycle * MS, WheelSpeeds::new(8.0, 4.0));
            assert!(
                (now.left_rad_s - (last.left_rad_s - 0.04)).abs() < 1e-9
                    && (now.left_rad_s - 2.0 * now.right_rad_s).abs() < 1e-9,
                "{now:?}"
            );
            last = now;
        }
        assert_eq!(ramp.stop(202 * MS, last), WheelSpeeds::STANDING);
    }

    #[test]
    fn a_stop_begins_where_the_wheels_are() {
        let mut ramp = WheelRamp::new(40.0);
        ramp.follow(MS, WheelSpeeds::new(8.0, 4.0), 35.0);
        let first = ramp.stop(2 * MS, WheelSpeeds::new(2.0, 1.0));
        assert!((first.left_rad_s - 1.96).abs() < 1e-9, "{first:?}");
        // From there it is the ramp, whatever the wheels do.
        let second = ramp.stop(3 * MS, WheelSpeeds::STANDING);
        assert!((second.left_rad_s - 1.92).abs() < 1e-9, "{second:?}");
    }

    #[test]
    fn what_is_not_a_number_stops_the_wheels() {
        let mut ramp = WheelRamp::new(40.0);
        ramp.follow(MS, WheelSpeeds::new(1.0, 1.0), 35.0);
        let broken = WheelSpeeds::new(f64::NAN, 1.0);
        assert_eq!(ramp.follow(100 * MS, broken, 35.0), WheelSpeeds::STANDING);
    }

    proptest! {
        #[test]
        fn no_wheel_is_ever_over_the_limit(
            setpoints in prop::collection::vec((-1e6_f64..1e6, -1e6_f64..1e6, any::<bool>()), 1..50)
        ) {
            let mut ramp = WheelRamp::new(40.0);
            for (cycle, (left, right, stop)) in setpoints.into_iter().enumerate() {
                let now_ns = cycle as u64 * MS;
                let wanted = WheelSpeeds::new(left, right);
                let sent = if stop { ramp.stop(now_ns, wanted) } else { ramp.follow(now_ns, wanted, 35.0) };
                prop_assert!(sent.fastest_rad_s() <= 35.0 + 1e-9);
            }
        }
    }
}
