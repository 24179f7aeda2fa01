//! Panics of a robot's program on the simulated clock, and how its process ends after one, or when it is told to.

use std::panic::resume_unwind;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use drivers::Clock;
use onboard::process::runner::EventLoop;
use onboard::process::supervisor::{STOPPING_NS, Supervisor, UNSUPERVISED_NS};
use onboard::realtime::panic::Panicked;

use super::thread::{Thread, ThreadClock, runs};

/// A thread that can be told to panic.
pub(super) struct Panicking {
    pub(super) thread: Thread,
    told: Arc<AtomicBool>,
}

impl Panicking {
    /// A thread that makes its loop and runs it. Whether it has panicked `panicked` says.
    pub(super) fn new(
        clock: Arc<ThreadClock>,
        make: impl FnOnce(Arc<dyn Clock>) -> EventLoop + 'static,
        panicked: Panicked,
    ) -> Self {
        let told = Arc::<AtomicBool>::default();
        let (own, hears) = (Arc::clone(&clock), Arc::clone(&told));
        let body = move || {
            let mut alive = true;
            let goes_on = || {
                // A coroutine is dropped by unwinding it, too, and nothing is left to be done then.
                if !runs() {
                    return false;
                }
                if hears.swap(false, Ordering::Relaxed) && std::mem::take(&mut alive) {
                    // A panic, without the hook, which is the whole process's.
                    resume_unwind(Box::new("a fault of the scenario"));
                }
                true
            };
            make(own).run(goes_on, &panicked);
        };
        let thread = Thread::new(clock, body);
        Self { thread, told }
    }

    /// It panics when its present turn is over.
    pub(super) fn panic(&self) {
        self.told.store(true, Ordering::Relaxed);
    }
}

/// How the process of a robot ends after a panic, or when it is told to.
#[derive(Default)]
pub(super) struct Ends {
    /// It has been told to.
    pub(super) told: bool,
    /// A part of it has panicked.
    pub(super) panicked: Panicked,
    /// That is no news: a fault of the scenario has it do so, or it was asked before.
    known: bool,
    /// So has its main thread.
    unsupervised: bool,
    /// Its activities have been told to stop, or nobody is there to tell them: it ends then at the latest.
    at_ns: Option<u64>,
    /// It has ended.
    pub(super) over: bool,
}

impl Ends {
    /// The main thread panics.
    pub(super) fn lose_supervisor(&mut self, now_ns: u64) {
        self.unsupervised = true;
        self.at_ns = Some(now_ns + UNSUPERVISED_NS);
        self.panicked.raise();
    }

    /// A fault of the scenario has a part of it panic.
    pub(super) fn expect_panic(&mut self) {
        self.known = true;
    }

    /// Whether a part of it has panicked by itself since this was asked last.
    pub(super) fn panics_by_itself(&mut self) -> bool {
        let news = self.panicked.is_raised() && !self.known;
        self.known |= news;
        news
    }

    /// The robot that is to end stands, says its supervisor: activities are to stop.
    pub(super) fn stop(&mut self, supervisor: &mut Supervisor, now_ns: u64) {
        supervisor.tell_to_stop();
        self.at_ns = Some(now_ns + STOPPING_NS);
    }

    /// Whether it goes on without its supervisor for a while, or ends.
    pub(super) fn is_unsupervised(&mut self, now_ns: u64) -> bool {
        self.over |= self.unsupervised && self.at_ns.is_some_and(|at_ns| now_ns >= at_ns);
        self.unsupervised
    }

    /// Whether its activities stop.
    pub(super) fn stops(&mut self, supervisor: &mut Supervisor, now_ns: u64) -> bool {
        if let Some(at_ns) = self.at_ns
            && !self.over
        {
            self.over = supervisor.have_stopped(now_ns) || now_ns >= at_ns;
            if self.over && !self.panicked.is_raised() {
                supervisor.arrive();
            }
        }
        self.at_ns.is_some()
    }
}
