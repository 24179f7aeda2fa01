//! A computer that sleeps: nothing runs meanwhile, and when it wakes nobody knows what has become of the robot.

use super::holders::Who;
use super::sent::answer;
use super::supervision::Supervisor;
use crate::process::ctl::{Pending, Refusal, Request};
use crate::realtime::clock::{MILLISECOND_NS, SECOND_NS};
use crate::symbols::faults::Fault;

/// It has slept when it has for longer than this since it was last awake for sure: less is two looks at clocks between which this
/// thread was held up.
const SLEPT_NS: u64 = 200 * MILLISECOND_NS;

impl Supervisor {
    /// The computer has slept for `slept_ns` in all. Whatever moved the robot meanwhile was not seen: as one that was switched off, it
    /// waits to be told where it is. Who held it, or asked for something before, has to ask again, but for a stop: `next_request` gives
    /// what waits.
    pub fn heed_sleep(
        &mut self,
        slept_ns: u64,
        mut next_request: impl FnMut() -> Option<Pending>,
        now_ns: u64,
    ) {
        let before_ns = *self.slept_ns.get_or_insert(slept_ns);
        let for_ns = slept_ns.saturating_sub(before_ns);
        if for_ns <= SLEPT_NS {
            return;
        }
        self.slept_ns = Some(slept_ns);
        let slept_s = for_ns as f64 / SECOND_NS as f64;
        tracing::error!(
            "the computer has slept for {slept_s:.1} s: stopping; `onboard doctor` says how to keep it awake"
        );
        self.take_back("the computer has slept");
        self.lost = true;
        self.raise(Who::Supervisor, Fault::PlaceUnknown, slept_s, now_ns);
        let carried_out = [&mut self.resets, &mut self.placings].map(|own| own.due(u64::MAX));
        let sent = self.sent.take().map(|sent| sent.pending);
        for pending in carried_out.into_iter().flatten().chain(sent) {
            answer(pending, &Err(Refusal::Slept));
        }
        while let Some(pending) = next_request() {
            // To stand is right at any time.
            match pending.request {
                Request::Stop | Request::Pause => self.serve(pending, now_ns),
                _ => answer(pending, &Err(Refusal::Slept)),
            }
        }
    }
}
