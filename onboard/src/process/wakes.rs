//! When the asynchronous loop runs, without threads and clock: on its thread, and on a simulated clock.
//!
//! It runs with a period, and at once on news; a wake-up of a real-time thread becomes news on its way through [`Passing`].

use crate::realtime::wake::Wake;

/// Turns wake-ups into news.
#[derive(Debug)]
pub struct Passing {
    seen: u32,
}

impl Passing {
    /// Wake-ups from now on are to be passed on. To be made before anybody who waits for them begins.
    #[must_use]
    pub fn new(wake: &Wake) -> Self {
        Self { seen: wake.count() }
    }

    /// How many wake-ups have been looked at.
    #[must_use]
    pub fn seen(&self) -> u32 {
        self.seen
    }

    /// Looks at the count of wake-ups. Returns whether there is news.
    #[must_use]
    pub fn look(&mut self, count: u32) -> bool {
        std::mem::replace(&mut self.seen, count) != count
    }
}

/// The loop is to run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Due {
    /// How long after its tick, or after the news came. Nanoseconds.
    pub late_ns: u64,
}

/// When the loop runs. Times are nanoseconds of the clock that is handed in.
#[derive(Debug)]
pub struct Wakes {
    period_ns: u64,
    tick_ns: u64,
}

impl Wakes {
    /// The first tick is at `begin_ns`.
    #[must_use]
    pub fn new(period_ns: u64, begin_ns: u64) -> Self {
        Self {
            period_ns: period_ns.max(1),
            tick_ns: begin_ns,
        }
    }

    /// When the next tick is.
    #[must_use]
    pub fn tick_ns(&self) -> u64 {
        self.tick_ns
    }

    /// Whether the loop is to run now. `told_ns` is when the oldest news came that it has not looked at, if there is any.
    /// Ticks that were missed are skipped, and those after them stay on their grid.
    #[must_use]
    pub fn look(&mut self, now_ns: u64, told_ns: Option<u64>) -> Option<Due> {
        let since_ns = if let Some(late_ns) = now_ns.checked_sub(self.tick_ns) {
            let tick_ns = self.tick_ns;
            self.tick_ns += (late_ns / self.period_ns + 1) * self.period_ns;
            tick_ns
        } else {
            // Without news somebody else has looked at it already.
            told_ns?
        };
        Some(Due {
            late_ns: now_ns.saturating_sub(since_ns),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn late_ns(due: Option<Due>) -> Option<u64> {
        due.map(|own| own.late_ns)
    }

    #[test]
    fn it_runs_on_its_grid_and_skips_what_it_has_missed() {
        let mut wakes = Wakes::new(10, 100);
        assert_eq!(late_ns(wakes.look(99, None)), None);
        assert_eq!(late_ns(wakes.look(100, None)), Some(0));
        assert_eq!(late_ns(wakes.look(100, None)), None, "once for each tick");
        assert_eq!(late_ns(wakes.look(112, None)), Some(2));
        assert_eq!(wakes.tick_ns(), 120);
        // Held up for three periods and a half: one turn for all of them.
        assert_eq!(late_ns(wakes.look(155, None)), Some(35));
        assert_eq!(late_ns(wakes.look(156, None)), None);
        assert_eq!(wakes.tick_ns(), 160);
    }

    #[test]
    fn it_runs_on_news_at_once_and_news_moves_no_tick() {
        let mut wakes = Wakes::new(10, 100);
        assert_eq!(late_ns(wakes.look(95, Some(93))), Some(2));
        assert_eq!(wakes.tick_ns(), 100);
        // Both at once are one turn.
        assert_eq!(late_ns(wakes.look(100, Some(99))), Some(0));
        assert_eq!(late_ns(wakes.look(101, None)), None);
        // By another clock than the loop's.
        assert_eq!(late_ns(wakes.look(102, Some(900))), Some(0));
    }

    #[test]
    fn every_wake_up_since_it_was_made_is_news_once() {
        let wake = Wake::default();
        wake.wake(1);
        let mut passing = Passing::new(&wake);
        assert!(!passing.look(wake.count()), "before its time");
        // Before anybody has looked for the first time.
        let mut early = Passing::new(&wake);
        wake.wake(2);
        assert!(early.look(wake.count()) && passing.look(wake.count()));
        assert!(!early.look(wake.count()));
        wake.wake(3);
        wake.wake(4);
        assert!(early.look(wake.count()));
        assert_eq!(early.seen(), wake.count());
    }
}
