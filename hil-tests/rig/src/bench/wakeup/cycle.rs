//! How a thread sleeps, and how its wake-ups are counted: alike for ours and for the rival.

use std::time::Duration;

use crate::bench::place::Place;
use crate::bench::samples::Sample;

/// How a thread runs.
#[derive(Clone, Copy, Debug)]
pub(super) struct Cycle {
    /// From one wake-up to the next.
    pub(super) period: Duration,
    /// Its core and priority.
    pub(super) place: Place,
}

impl Cycle {
    /// How many fit into a time.
    pub(super) fn count(&self, time: Duration) -> u64 {
        (time.as_nanos() / self.period.as_nanos().max(1)) as u64
    }
}

/// In whole µs, as `cyclictest` counts, and without a time, which it does not tell.
pub(super) fn as_counted(late_ns: u64) -> Sample {
    Sample::sometime((late_ns / 1_000 * 1_000) as f64)
}
