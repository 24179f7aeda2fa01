//! From a scan to the wheels: from the last byte that the lidar hands over to the frame that has the setpoints which follow from it.

use std::cell::Cell;
use std::time::Duration;

use onboard::cli::Failure;
use onboard::realtime::clock::sleep_until;
use sim::rt::monotonic_ns;

use super::chase::Chase;
use super::eyes::Eyes;
use crate::bench::place::Place;
use crate::bench::samples::Sample;
use crate::bench::windows::Contender;

/// From one look to the next, which is how late a step is seen at most. There are three steps.
const LOOK_NS: u64 = 50_000;
/// A robot whose scans have led to nothing by then is not one that drives.
const PATIENCE: Duration = Duration::from_secs(10);

/// Watches scans become setpoints.
pub(super) struct ScanToWheel<'a> {
    eyes: Eyes,
    place: Place,
    missed: &'a Cell<u64>,
}

impl<'a> ScanToWheel<'a> {
    /// Watches from this place; counts scans whose setpoints were not seen.
    pub(super) fn new(eyes: Eyes, place: Place, missed: &'a Cell<u64>) -> Self {
        Self {
            eyes,
            place,
            missed,
        }
    }
}

impl Contender for ScanToWheel<'_> {
    fn name(&self) -> String {
        "onboard".to_owned()
    }

    fn window(&mut self, length: Duration, into: &mut Vec<Sample>) -> Result<(), Failure> {
        let (eyes, place) = (&mut self.eyes, self.place);
        // On a thread of its own, whose priority ends with it.
        let watched = std::thread::scope(|scope| {
            let thread = std::thread::Builder::new().name("watch".to_owned());
            let thread = thread.spawn_scoped(scope, || watch(eyes, place, length));
            thread.map(|thread| thread.join())
        });
        let panicked = |_| Failure::failed("the watching thread panicked");
        let watched = watched.map_err(Failure::failed)?.map_err(panicked)?;
        let (samples, missed) = watched?;
        self.missed.set(self.missed.get() + missed);
        into.extend(samples);
        Ok(())
    }
}

/// Watches for so long, and on until there is a sample. Returns the samples, and how many scans were missed.
fn watch(eyes: &mut Eyes, place: Place, length: Duration) -> Result<(Vec<Sample>, u64), Failure> {
    place.take()?;
    let (mut chase, mut samples) = (Chase::default(), Vec::new());
    let mut next_ns = monotonic_ns();
    let end_ns = next_ns + length.as_nanos() as u64;
    while next_ns < end_ns || samples.is_empty() {
        if next_ns > end_ns + PATIENCE.as_nanos() as u64 {
            return Err(Failure::failed("no scan has led to a setpoint"));
        }
        samples.extend(chase.look(&eyes.look()));
        next_ns = (next_ns + LOOK_NS).max(monotonic_ns());
        sleep_until(next_ns);
    }
    Ok((samples, chase.missed))
}
