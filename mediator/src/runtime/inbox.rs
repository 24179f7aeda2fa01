//! What waits for management, between its thread and those of the network.

use std::sync::{Condvar, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use super::input::{Asked, Input};
use super::waiting::Waiting;
use contract::wire::RobotReport;

/// [`Waiting`], and somebody who waits for it.
pub(super) struct Inbox {
    waiting: Mutex<Waiting>,
    news: Condvar,
}

impl Inbox {
    pub(super) fn new(waiting: Waiting) -> Self {
        Self {
            waiting: Mutex::new(waiting),
            news: Condvar::new(),
        }
    }

    fn waiting(&self) -> MutexGuard<'_, Waiting> {
        self.waiting.lock().unwrap_or_else(PoisonError::into_inner)
    }

    pub(super) fn report(&self, report: Box<RobotReport>) {
        self.waiting().report(report);
        self.news.notify_one();
    }

    /// Whether there was room.
    pub(super) fn ask(&self, asked: Asked) -> bool {
        let fits = self.waiting().ask(asked);
        self.news.notify_one();
        fits
    }

    pub(super) fn knows(&self, robot_id: &str) -> bool {
        self.waiting().knows(robot_id)
    }

    /// How many the site lists.
    pub(super) fn robots(&self) -> usize {
        self.waiting().robots()
    }

    pub(super) fn dropped(&self) -> u64 {
        self.waiting().dropped()
    }

    /// All that waits, after at most this time.
    pub(super) fn take(&self, within: Duration) -> Vec<Input> {
        let nothing = |waiting: &mut Waiting| waiting.is_empty();
        let waited = self
            .news
            .wait_timeout_while(self.waiting(), within, nothing);
        let (mut waiting, _) = waited.unwrap_or_else(PoisonError::into_inner);
        std::iter::from_fn(|| waiting.take_next()).collect()
    }
}
