//! Runs that compute take turns, one for each core: programs of other tests, which are judged by the time they take, need some too.

use std::sync::{Condvar, Mutex, PoisonError};

static WORKING: Mutex<usize> = Mutex::new(0);
static ONE_IS_DONE: Condvar = Condvar::new();

/// A core to compute on, while it lives.
pub struct Core;

impl Core {
    /// Waits until there is one.
    pub fn wait() -> Self {
        let cores = std::thread::available_parallelism().map_or(1, usize::from);
        let working = WORKING.lock().unwrap_or_else(PoisonError::into_inner);
        let free = ONE_IS_DONE.wait_while(working, |working| *working >= cores);
        *free.unwrap_or_else(PoisonError::into_inner) += 1;
        Self
    }
}

impl Drop for Core {
    fn drop(&mut self) {
        *WORKING.lock().unwrap_or_else(PoisonError::into_inner) -= 1;
        ONE_IS_DONE.notify_one();
    }
}
