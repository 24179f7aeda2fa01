//! A thread with the clock and the priority of a robot's.

use std::time::Duration;

use onboard::cli::Failure;
use onboard::realtime::clock::sleep_until;
use onboard::realtime::latency::keep_cores_awake;
use onboard::realtime::memory::{populate_memory, prefault_stack};
use sim::rt::monotonic_ns;

use crate::bench::cycle::Cycle;
use crate::bench::measuring::Measuring;
use crate::bench::samples::Sample;
use crate::bench::windows::Contender;

/// A thread of each window's own.
pub(super) struct Ours(pub(super) Cycle);

impl Contender for Ours {
    fn name(&self) -> String {
        "onboard".to_owned()
    }

    fn window(&mut self, length: Duration, into: &mut Vec<Sample>) -> Result<(), Failure> {
        let cycle = self.0;
        let cycles = cycle.count(length);
        // As onboard and cyclictest do: without it cores sleep deeply. Where it is not allowed, it is not for cyclictest either.
        let _awake = keep_cores_awake();
        let late_ns = Measuring::spawn("wakeup", move || sleep(cycle, cycles))?.end();
        // The other parts find memory as they left it.
        let _ = rustix::mm::munlockall();
        into.extend(late_ns?.into_iter().map(Sample::counted_in_us));
        Ok(())
    }
}

/// How late each wake-up was, nanoseconds.
fn sleep(cycle: Cycle, cycles: u64) -> Result<Vec<u64>, Failure> {
    let mut late_ns = Vec::with_capacity(cycles as usize);
    prefault_stack();
    // As cyclictest does. Where it is not allowed, it is not for cyclictest either.
    let _ = populate_memory();
    cycle.place.take()?;
    let period_ns = cycle.period.as_nanos() as u64;
    let mut planned_ns = monotonic_ns();
    for _ in 0..cycles {
        planned_ns += period_ns;
        sleep_until(planned_ns);
        let now_ns = monotonic_ns();
        late_ns.push(now_ns.saturating_sub(planned_ns));
        // As cyclictest does: what was missed is not made up for.
        while planned_ns + period_ns <= now_ns {
            planned_ns += period_ns;
        }
    }
    Ok(late_ns)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bench::place::{Place, last_core};

    #[test]
    fn each_wake_up_is_measured() {
        let (place, _) = Place::wanted(10, last_core());
        let period = Duration::from_millis(1);
        let mut ours = Ours(Cycle { period, place });
        let mut samples = Vec::new();
        let worked = ours.window(50 * period, &mut samples);
        assert!(worked.is_ok(), "{worked:?}");
        assert_eq!(samples.len(), 50);
        assert!(samples.iter().all(|sample| sample.value % 1_000.0 == 0.0));
    }
}
