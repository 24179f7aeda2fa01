//! What wakes the communication activity's loop before its period is over.

use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use tokio::sync::Notify;

use crate::realtime::clock::now_ns;
use crate::realtime::wake::Wake;

/// Wakes the loop, from any thread that may take a lock.
#[derive(Clone, Debug, Default)]
pub struct News(Arc<Told>);

#[derive(Debug)]
struct Told {
    notify: Notify,
    /// When the oldest news came that the loop has not looked at, or [`NONE`].
    since_ns: AtomicU64,
}

const NONE: u64 = u64::MAX;

impl Default for Told {
    fn default() -> Self {
        Self {
            notify: Notify::new(),
            since_ns: AtomicU64::new(NONE),
        }
    }
}

impl News {
    /// There is something to look at.
    pub fn tell(&self) {
        // Always a write, also when older news waits: whoever takes it sees all that was done before this.
        self.0.since_ns.fetch_min(now_ns(), Ordering::AcqRel);
        self.0.notify.notify_one();
    }

    /// Waits for news.
    pub async fn wait(&self) {
        self.0.notify.notified().await;
    }

    /// When the oldest waiting news came; from now on none is waiting.
    #[must_use]
    pub fn take(&self) -> Option<u64> {
        match self.0.since_ns.swap(NONE, Ordering::AcqRel) {
            NONE => None,
            since_ns => Some(since_ns),
        }
    }
}

/// What wakes the thread besides its period.
#[derive(Clone, Debug, Default)]
pub struct Alarm {
    /// For threads that may take a lock.
    pub news: News,
    /// For real-time threads.
    pub wake: Wake,
}
