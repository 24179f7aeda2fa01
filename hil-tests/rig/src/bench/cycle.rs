//! How a thread repeats what is measured: alike for ours and for its rival.

use std::time::Duration;

use super::place::Place;

/// How a thread runs.
#[derive(Clone, Copy, Debug)]
pub struct Cycle {
    /// From one cycle to the next.
    pub period: Duration,
    /// Its core and priority.
    pub place: Place,
}

impl Cycle {
    /// How many fit into a time.
    #[must_use]
    pub fn count(&self, time: Duration) -> u64 {
        (time.as_nanos() / self.period.as_nanos().max(1)) as u64
    }
}
