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
/// An older answer says nothing about now.
const FRESH_NS: u64 = 2_000_000_000;

/// A coordination, with times of our clock.
#[derive(Clone, Debug)]
pub struct Course {
    /// What was told last.
    pub status: CoordinationStatus,
    /// When it began.
    pub from_ns: u64,
    /// When it was over.
    pub to_ns: Option<u64>,
    /// What fired, in order.
    pub firings: Vec<(String, u64)>,
    fired: u64,
    /// Where the mediator counts from.
    base_ns: u64,
}

/// All that was told.
#[derive(Clone, Debug, Default)]
pub struct Seen {
    status: Option<(u64, Status)>,
    /// By number.
    pub courses: BTreeMap<u64, Course>,
}

impl Seen {
    /// How everything stood a moment ago, if the mediator answers.
    #[must_use]
    pub fn status(&self) -> Option<&Status> {
        let (at_ns, status) = self.status.as_ref()?;
        (monotonic_ns().saturating_sub(*at_ns) < FRESH_NS).then_some(status)
    }

    fn take(&mut self, status: Status, now_ns: u64) {
        for own in &status.coordinations {
            self.follow(own, now_ns);
        }
        self.status = Some((now_ns, status));
    }

    fn follow(&mut self, own: &CoordinationStatus, now_ns: u64) {
        let ns = |ms: u64| ms.saturating_mul(1_000_000);
        // Since it began; or since the mediator did, which restarted meanwhile.
        let base_ns = now_ns.saturating_sub(ns(own.age_ms));
        let course = self.courses.entry(own.number).or_insert_with(|| Course {
            status: own.clone(),
            from_ns: base_ns,
            to_ns: None,
            firings: Vec::new(),
            fired: 0,
            base_ns,
        });
        if course.to_ns.is_some() {
            return;
        }
        // What is over does not grow older any more.
        if !own.over {
            course.base_ns = base_ns;
        }
        let base_ns = course.base_ns;
        // A restarted mediator counts anew.
        let known = if own.fired < course.fired {
            0
        } else {
            course.fired
        };
        let new = usize::try_from(own.fired - known).unwrap_or(usize::MAX);
        let skip = own.firings.len().saturating_sub(new);
        for (transition, at_ms) in own.firings.iter().skip(skip) {
            course
                .firings
                .push((transition.clone(), base_ns + ns(*at_ms)));
        }
        course.fired = own.fired;
        if own.over {
            course.to_ns = Some((base_ns + ns(own.age_ms)).min(now_ns));
        }
        course.status = own.clone();
    }
}

/// Asks in a thread of its own until it is dropped.
pub struct Board {
    seen: Arc<Mutex<Seen>>,
    stop: Arc<AtomicBool>,
    thread: Option<JoinHandle<()>>,
}

impl Board {
    /// Begins to ask at this control socket; nobody need answer there yet.
    ///
    /// # Errors
    /// The operating system's.
    pub fn watch(socket: PathBuf) -> std::io::Result<Self> {
        let seen = Arc::<Mutex<Seen>>::default();
        let stop = Arc::<AtomicBool>::default();
        let thread = {
            let (seen, stop) = (Arc::clone(&seen), Arc::clone(&stop));
            std::thread::Builder::new()
                .name("board".to_owned())
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
    pub fn seen(&self) -> MutexGuard<'_, Seen> {
        lock(&self.seen)
    }
}

impl Drop for Board {
    fn drop(&mut self) {
        self.stop.store(true, Ordering::Relaxed);
        if let Some(thread) = self.thread.take() {
            // It only asks.
            let _ = thread.join();
        }
    }
}

fn lock(seen: &Mutex<Seen>) -> MutexGuard<'_, Seen> {
    seen.lock().unwrap_or_else(PoisonError::into_inner)
}
