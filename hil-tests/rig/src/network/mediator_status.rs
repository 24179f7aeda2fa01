//! What the mediator tells its operators, asked a few times a second: shown to people, and the source of the firings of
//! nets, which nobody else knows. No violation is judged by it.

use std::collections::BTreeMap;
use std::path::PathBuf;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread::JoinHandle;
use std::time::Duration;

use mediator::manager::{CoordinationStatus, Status};
use mediator::runtime::{Answer, Question, ask};
use sim::rt::monotonic_ns;

const PERIOD: Duration = Duration::from_millis(200);
/// An older answer is not shown as the present state.
const FRESH_NS: u64 = 2_000_000_000;

/// A coordination, with times of this process's clock.
#[derive(Clone, Debug)]
pub struct CoordinationSeen {
    /// What was told last.
    pub status: CoordinationStatus,
    /// When it began.
    pub from_ns: u64,
    /// When it was over.
    pub to_ns: Option<u64>,
    /// What fired, in order.
    pub firings: Vec<(String, u64)>,
    fired: u64,
    epoch: u64,
    /// Where the mediator counts from.
    base_ns: u64,
}

/// All that was told.
#[derive(Clone, Debug, Default)]
pub struct Told {
    status: Option<(u64, Status)>,
    /// By number.
    pub coordinations: BTreeMap<u64, CoordinationSeen>,
}

impl Told {
    /// The last status, if the mediator has answered recently.
    #[must_use]
    pub fn status(&self, now_ns: u64) -> Option<&Status> {
        let (at_ns, status) = self.status.as_ref()?;
        (now_ns.saturating_sub(*at_ns) < FRESH_NS).then_some(status)
    }

    /// Takes in what was told at `now_ns`, times of this process's clock.
    pub fn take(&mut self, status: Status, now_ns: u64) {
        for own in &status.coordinations {
            self.follow(own, status.epoch, now_ns);
        }
        self.status = Some((now_ns, status));
    }

    fn follow(&mut self, own: &CoordinationStatus, epoch: u64, now_ns: u64) {
        let ns = |ms: u64| ms.saturating_mul(1_000_000);
        // When it began; after a restart of the mediator, when that began.
        let base_ns = now_ns.saturating_sub(ns(own.age_ms));
        let seen = self
            .coordinations
            .entry(own.number)
            .or_insert_with(|| CoordinationSeen {
                status: own.clone(),
                from_ns: base_ns,
                to_ns: None,
                firings: Vec::new(),
                fired: 0,
                epoch,
                base_ns,
            });
        if seen.to_ns.is_some() {
            return;
        }
        // The age of a coordination that is over no longer grows.
        if !own.over {
            seen.base_ns = base_ns;
        }
        let base_ns = seen.base_ns;
        // A restarted mediator counts firings from 0.
        let known = if epoch == seen.epoch { seen.fired } else { 0 };
        seen.epoch = epoch;
        let new = usize::try_from(own.fired.saturating_sub(known)).unwrap_or(usize::MAX);
        let skip = own.firings.len().saturating_sub(new);
        for (transition, at_ms) in own.firings.iter().skip(skip) {
            seen.firings
                .push((transition.clone(), base_ns + ns(*at_ms)));
        }
        seen.fired = own.fired;
        if own.over {
            seen.to_ns = Some((base_ns + ns(own.age_ms)).min(now_ns));
        }
        seen.status = own.clone();
    }
}

/// Asks in a thread of its own until it is dropped.
pub struct MediatorWatch {
    seen: Arc<Mutex<Told>>,
    stop: Arc<AtomicBool>,
    thread: Option<JoinHandle<()>>,
}

impl MediatorWatch {
    /// Starts to ask at this control socket; the mediator need not run yet.
    ///
    /// # Errors
    /// The operating system's.
    pub fn start(socket: PathBuf) -> std::io::Result<Self> {
        let seen = Arc::<Mutex<Told>>::default();
        let stop = Arc::<AtomicBool>::default();
        let thread = {
            let (seen, stop) = (Arc::clone(&seen), Arc::clone(&stop));
            std::thread::Builder::new()
                .name("mediator-watch".to_owned())
                .spawn(move || {
                    while !stop.load(Ordering::Relaxed) {
                        if let Ok(Answer::Status(status)) = ask(&socket, &Question::Status) {
                            lock(&seen).take(*status, monotonic_ns());
                        }
                        std::thread::sleep(PERIOD);
                    }
                })?
        };
        Ok(Self {
            seen,
            stop,
            thread: Some(thread),
        })
    }

    /// All that was told.
    pub fn told(&self) -> MutexGuard<'_, Told> {
        lock(&self.seen)
    }
}

impl Drop for MediatorWatch {
    fn drop(&mut self) {
        self.stop.store(true, Ordering::Relaxed);
        if let Some(thread) = self.thread.take() {
            // It only asks.
            let _ = thread.join();
        }
    }
}

fn lock(seen: &Mutex<Told>) -> MutexGuard<'_, Told> {
    seen.lock().unwrap_or_else(PoisonError::into_inner)
}

#[cfg(test)]
mod tests {
    use super::*;

    const MS: u64 = 1_000_000;

    fn status(epoch: u64, fired: u64, firings: &[(&str, u64)], age_ms: u64, over: bool) -> Status {
        let own = CoordinationStatus {
            number: 1,
            id: "passing".into(),
            net: "passing".into(),
            situation: "ahead".into(),
            robots: Vec::new(),
            marking: Vec::new(),
            firings: { firings.iter() }
                .map(|&(transition, at_ms)| (transition.to_owned(), at_ms))
                .collect(),
            fired,
            waits: Vec::new(),
            age_ms,
            still_ms: 0,
            over,
        };
        Status {
            epoch,
            stands_by: false,
            awaited: Vec::new(),
            areas: Vec::new(),
            robots: Vec::new(),
            coordinations: vec![own],
        }
    }

    fn firings(seen: &Told) -> Vec<(&str, u64)> {
        { seen.coordinations[&1].firings.iter() }
            .map(|(transition, at_ns)| (transition.as_str(), at_ns / MS))
            .collect()
    }

    #[test]
    fn firings_are_written_down_once_with_times_of_our_clock() {
        let mut seen = Told::default();
        seen.take(status(1, 1, &[("a", 5)], 100, false), 1_100 * MS);
        seen.take(status(1, 1, &[("a", 5)], 300, false), 1_300 * MS);
        // Only the last ones are told.
        seen.take(
            status(1, 3, &[("b", 350), ("c", 390)], 500, false),
            1_500 * MS,
        );
        seen.take(
            status(1, 4, &[("c", 390), ("d", 600)], 620, true),
            1_700 * MS,
        );
        // What is over stays as it is.
        seen.take(
            status(1, 4, &[("c", 390), ("d", 600)], 620, true),
            9_000 * MS,
        );
        let expected = [("a", 1_005), ("b", 1_350), ("c", 1_390), ("d", 1_600)];
        assert_eq!(firings(&seen), expected);
        let one = &seen.coordinations[&1];
        assert_eq!((one.from_ns, one.to_ns), (1_000 * MS, Some(1_620 * MS)));
    }

    #[test]
    fn a_mediator_that_restarted_counts_from_its_own_start() {
        let mut seen = Told::default();
        seen.take(status(1, 1, &[("a", 5)], 100, false), 1_100 * MS);
        seen.take(status(2, 1, &[("b", 50)], 60, false), 5_060 * MS);
        let one = &seen.coordinations[&1];
        assert_eq!(one.from_ns, 1_000 * MS);
        seen.take(status(2, 2, &[("b", 50), ("c", 70)], 80, true), 5_100 * MS);
        assert_eq!(seen.coordinations[&1].to_ns, Some(5_080 * MS));
        assert_eq!(firings(&seen).last(), Some(&("c", 5_070)));
    }
}
