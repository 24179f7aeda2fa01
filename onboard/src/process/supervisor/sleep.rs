//! A computer that sleeps: its monotonic clock stands still meanwhile, so that no deadline tells of it.

use super::holders::Who;
use super::supervision::Supervisor;
use crate::realtime::clock::{MILLISECOND_NS, SECOND_NS};
use crate::symbols::faults::Fault;

/// It has slept when it has for longer than this: less is two looks at clocks between which this thread was held up.
const SLEPT_NS: u64 = 200 * MILLISECOND_NS;

impl Supervisor {
    /// The computer has slept for `slept_ns` in all. What was heard just before may be hours old, and the robot somewhere else: as one
    /// that was switched off, it waits to be told where it is.
    pub fn heed_sleep(&mut self, slept_ns: u64, now_ns: u64) {
        let before_ns = self.slept_ns.unwrap_or(slept_ns);
        self.slept_ns = Some(before_ns.max(slept_ns));
        let slept_ns = slept_ns.saturating_sub(before_ns);
        if slept_ns > SLEPT_NS {
            let slept_s = slept_ns as f64 / SECOND_NS as f64;
            tracing::error!(
                "the computer has slept for {slept_s:.1} s: stopping; `onboard doctor` says how to keep it awake"
            );
            self.lost = true;
            self.raise(Who::Supervisor, Fault::PlaceUnknown, slept_s, now_ns);
        }
    }
}
