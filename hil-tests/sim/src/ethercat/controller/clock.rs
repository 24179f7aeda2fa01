//! The distributed clock of one SubDevice (ETG.1000.4 table 60): local time, system time, and how it follows a
//! reference.
//!
//! All simulated clocks tick at the same rate, so following only has to remove a difference in phase. No SYNC
//! signals are generated.

/// Largest correction by one received system time.
const MAX_STEP_NS: i64 = 1000;
/// Share of the difference that is corrected by one received system time.
const STEP_DIVISOR: i64 = 16;
/// Sign bit of the difference register: the local copy is behind.
const BEHIND: u32 = 0x8000_0000;

/// A clock that started at power-on.
#[derive(Debug, Clone, Default)]
pub struct Clock {
    power_on_ns: u64,
    stopped_at_ns: Option<u64>,
    stopped_for_ns: u64,
    correction_ns: i64,
    difference: u32,
    /// Added to the local time to get the system time (register 0x0920).
    pub offset_ns: u64,
    /// Delay to the reference clock (register 0x0928).
    pub delay_ns: u32,
}

impl Clock {
    /// A clock whose local time is 0 at `now_ns`.
    #[must_use]
    pub fn new(now_ns: u64) -> Clock {
        Clock {
            power_on_ns: now_ns,
            ..Clock::default()
        }
    }

    /// Local time.
    #[must_use]
    pub fn local_ns(&self, now_ns: u64) -> u64 {
        let now_ns = self.stopped_at_ns.unwrap_or(now_ns);
        now_ns
            .saturating_sub(self.power_on_ns)
            .saturating_sub(self.stopped_for_ns)
            .wrapping_add_signed(self.correction_ns)
    }

    /// System time, as a MainDevice has set it up.
    #[must_use]
    pub fn system_ns(&self, now_ns: u64) -> u64 {
        self.local_ns(now_ns).wrapping_add(self.offset_ns)
    }

    /// The difference register (0x092C).
    #[must_use]
    pub fn difference(&self) -> u32 {
        self.difference
    }

    /// Takes the lower half of a reference clock's system time.
    pub fn follow(&mut self, received: u32, now_ns: u64) {
        let own = self.system_ns(now_ns) as u32;
        let ahead = own.wrapping_sub(received.wrapping_add(self.delay_ns)) as i32;
        self.difference = if ahead < 0 {
            BEHIND | ahead.unsigned_abs() & !BEHIND
        } else {
            ahead as u32
        };
        let step = (i64::from(ahead) / STEP_DIVISOR).clamp(-MAX_STEP_NS, MAX_STEP_NS);
        self.correction_ns = self.correction_ns.wrapping_sub(step);
    }

    /// Resets the control loop.
    pub fn reset_loop(&mut self) {
        self.difference = 0;
    }

    /// Stops the clock, or lets it go on from where it stopped.
    pub fn set_stopped(&mut self, stopped: bool, now_ns: u64) {
        match (stopped, self.stopped_at_ns) {
            (true, None) => self.stopped_at_ns = Some(now_ns),
            (false, Some(since)) => {
                self.stopped_for_ns += now_ns.saturating_sub(since);
                self.stopped_at_ns = None;
            }
            _ => {}
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn system_time_is_local_time_plus_offset() {
        let mut clock = Clock::new(1_000);
        clock.offset_ns = (-500i64) as u64;
        assert_eq!(
            (clock.local_ns(2_000), clock.system_ns(2_000)),
            (1_000, 500)
        );
    }

    #[test]
    fn a_follower_reaches_its_reference() {
        let mut clock = Clock::new(0);
        clock.delay_ns = 100;
        for i in 0..2000u64 {
            let now = i * 1_000_000;
            clock.follow((now + 40_000) as u32, now);
        }
        let now = 2_000_000_000;
        assert!(
            clock.system_ns(now).abs_diff(now + 40_100) < 20,
            "{}",
            clock.system_ns(now)
        );
        assert!(clock.difference() & !BEHIND < 20);
        clock.reset_loop();
        assert_eq!(clock.difference(), 0);
    }

    #[test]
    fn a_stopped_clock_goes_on_without_a_jump() {
        let mut clock = Clock::new(0);
        clock.set_stopped(true, 100);
        clock.set_stopped(true, 150);
        assert_eq!(clock.local_ns(200), 100);
        clock.set_stopped(false, 300);
        assert_eq!(clock.local_ns(310), 110);
    }
}
