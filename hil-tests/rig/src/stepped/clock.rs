//! The simulated clock, and those of the robots' computers: each counts from when it was switched on.

use sim::world::Random;

/// Where it starts: 0 means "never" to a robot.
pub const START_NS: u64 = 1_000_000_000;
/// Its step.
pub const STEP_NS: u64 = 1_000_000;

/// The clock of a robot's computer.
pub(super) struct OwnClock {
    /// How fast it gets ahead of the world's,
    drift: f64,
    /// how far it is ahead, nanoseconds, or behind,
    ahead_ns: f64,
    /// and when it was looked at last.
    looked_ns: u64,
    /// The computer sleeps,
    sleeps: bool,
    /// and has for so long in all, nanoseconds.
    slept_ns: f64,
}

impl OwnClock {
    /// One that is so far ahead at a time of the world's.
    pub(super) fn new(ahead_ns: f64, world_ns: u64) -> Self {
        Self {
            drift: 0.0,
            ahead_ns,
            looked_ns: world_ns,
            sleeps: false,
            slept_ns: 0.0,
        }
    }

    /// From now on it runs faster than the world's by this share, or slower.
    pub(super) fn drift(&mut self, share: f64) {
        self.drift = share;
    }

    /// From now on the computer sleeps, or is awake.
    pub(super) fn sleep(&mut self, sleeps: bool) {
        self.sleeps = sleeps;
    }

    /// What it shows.
    pub(super) fn now_ns(&self) -> u64 {
        shown_ns(self.looked_ns, self.ahead_ns)
    }

    /// How far it is ahead of the world's, or behind.
    pub(super) fn ahead_ns(&self) -> f64 {
        self.ahead_ns
    }

    /// For how long the computer has slept.
    pub(super) fn slept_ns(&self) -> u64 {
        self.slept_ns as u64
    }

    /// A step begins at `world_ns`: from when to when by this clock, unless the computer sleeps.
    pub(super) fn step(&mut self, world_ns: u64) -> Option<[u64; 2]> {
        let passed_ns = (world_ns - self.looked_ns) as f64;
        self.looked_ns = world_ns;
        self.ahead_ns += passed_ns * self.drift;
        if self.sleeps {
            self.slept_ns += passed_ns;
            return None;
        }
        let ahead_ns = self.ahead_ns + STEP_NS as f64 * self.drift;
        Some([self.now_ns(), shown_ns(world_ns + STEP_NS, ahead_ns)])
    }
}

/// What a clock shows that is so far ahead of the world's, or behind it.
pub(super) fn shown_ns(world_ns: u64, ahead_ns: f64) -> u64 {
    world_ns.saturating_add_signed(ahead_ns as i64)
}

/// How far the clock of a computer is ahead of the world's that has run for up to a day already, in whole nanoseconds.
pub(super) fn drawn_ahead_ns(random: &mut Random) -> f64 {
    const DAY_NS: f64 = 86_400e9;
    (random.unit() * DAY_NS).round()
}

/// The same of one that is switched on now, by when a process runs on it.
pub(super) fn ahead_after_boot_ns(world_ns: u64) -> f64 {
    const BOOT_NS: f64 = 3e9;
    BOOT_NS - world_ns as f64
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_clock_drifts_and_goes_on_while_its_computer_sleeps() {
        let mut clock = OwnClock::new(500.0, 1_000_000);
        clock.drift(0.001);
        assert_eq!(clock.step(2_000_000), Some([2_001_500, 3_002_500]));
        clock.sleep(true);
        assert_eq!(clock.step(9_000_000), None);
        assert_eq!((clock.now_ns(), clock.slept_ns()), (9_008_500, 7_000_000));
        clock.sleep(false);
        clock.drift(0.0);
        assert_eq!(clock.step(10_000_000), Some([10_008_500, 11_008_500]));
    }
}
