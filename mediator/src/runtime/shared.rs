//! What both threads share.

use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::Instant;

use super::mediators::Mediators;

/// What both threads share.
#[derive(Debug)]
pub struct Shared {
    started: Instant,
    stop: AtomicBool,
    pub(super) dropped_outputs: AtomicU64,
    /// Messages under reports' keys that are none, and why the last one is not.
    pub(super) no_reports: AtomicU64,
    pub(super) last_no_report: Mutex<String>,
    /// What is wrong with the site's keys, as it was said last.
    keys: Mutex<String>,
    /// Other mediators that are there.
    mediators: Mutex<Mediators>,
}

impl Shared {
    pub(super) fn new() -> Self {
        Self {
            started: Instant::now(),
            stop: AtomicBool::new(false),
            dropped_outputs: AtomicU64::new(0),
            no_reports: AtomicU64::new(0),
            last_no_report: Mutex::new(String::new()),
            keys: Mutex::new(String::new()),
            mediators: Mutex::default(),
        }
    }

    /// The network cannot be opened, or its keys cannot be read: says so once.
    pub(super) fn note_keys(&self, why: &str) {
        let mut said = self.keys.lock().unwrap_or_else(PoisonError::into_inner);
        if *said != why {
            tracing::error!("{why}; it is tried again every second");
            why.clone_into(&mut said);
        }
    }

    /// It can again.
    pub(super) fn forget_keys(&self) {
        { self.keys.lock() }
            .unwrap_or_else(PoisonError::into_inner)
            .clear();
    }

    /// Another mediator has come to the network, or has gone: says so once, and so often in a minute.
    pub(super) fn note_mediator(&self, instance: u64, is_there: bool) {
        if !self.mediators().see(instance, is_there, self.now_ns()) {
            return;
        }
        if is_there {
            tracing::error!(
                "another mediator, {instance:016x}, is on this network: robots follow one of the two, and the other is to stand by; end the wrong one"
            );
        } else {
            tracing::info!("the other mediator, {instance:016x}, is gone");
        }
    }

    /// Says how often that was not said in a minute that is over.
    pub(super) fn count_mediators(&self) {
        if let Some(count) = self.mediators().left_out(self.now_ns()) {
            tracing::warn!(
                "other mediators have come to this network or gone {count} more times in the last minute: see who starts them again and again"
            );
        }
    }

    fn mediators(&self) -> MutexGuard<'_, Mediators> {
        self.mediators
            .lock()
            .unwrap_or_else(PoisonError::into_inner)
    }

    /// Nanoseconds since the start; nobody else's clock is ever compared with it.
    pub(super) fn now_ns(&self) -> u64 {
        u64::try_from(self.started.elapsed().as_nanos()).unwrap_or(u64::MAX)
    }

    /// A message is no report.
    pub(super) fn note_no_report(&self, why: String) {
        self.no_reports.fetch_add(1, Ordering::Relaxed);
        *{ self.last_no_report.lock() }.unwrap_or_else(PoisonError::into_inner) = why;
    }

    pub(super) fn is_stopping(&self) -> bool {
        self.stop.load(Ordering::Acquire)
    }

    /// Makes both threads end.
    pub fn stop(&self) {
        self.stop.store(true, Ordering::Release);
    }
}
