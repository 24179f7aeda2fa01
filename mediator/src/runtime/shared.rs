//! What both threads share.

use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::time::Instant;

/// What both threads share.
#[derive(Debug)]
pub struct Shared {
    started: Instant,
    stop: AtomicBool,
    pub(super) dropped_inputs: AtomicU64,
    pub(super) dropped_outputs: AtomicU64,
}

impl Shared {
    pub(super) fn new() -> Self {
        Self {
            started: Instant::now(),
            stop: AtomicBool::new(false),
            dropped_inputs: AtomicU64::new(0),
            dropped_outputs: AtomicU64::new(0),
        }
    }

    /// Nanoseconds since the start; nobody else's clock is ever compared with it.
    pub(super) fn now_ns(&self) -> u64 {
        u64::try_from(self.started.elapsed().as_nanos()).unwrap_or(u64::MAX)
    }

    pub(super) fn is_stopping(&self) -> bool {
        self.stop.load(Ordering::Acquire)
    }

    /// Makes both threads end.
    pub fn stop(&self) {
        self.stop.store(true, Ordering::Release);
    }
}
