//! Runs that compute take turns, one for each core: programs of other tests, which are judged by the time they take, need some too.

use std::cell::Cell;
use std::marker::PhantomData;
use std::sync::{Condvar, LazyLock, Mutex, PoisonError};

/// Asked for once: it reads files.
static CORES: LazyLock<usize> =
    LazyLock::new(|| std::thread::available_parallelism().map_or(1, usize::from));
static WORKING: Mutex<usize> = Mutex::new(0);
static ONE_IS_DONE: Condvar = Condvar::new();

thread_local! {
    /// How many a thread has of the one core that it computes on.
    static OWN: Cell<usize> = const { Cell::new(0) };
}

/// A core to compute on, while it lives. It is of the thread that waited, which may have it more than once.
pub struct Core(PhantomData<*const ()>);

impl Core {
    /// Waits until there is one.
    pub fn wait() -> Self {
        let own = OWN.replace(OWN.get() + 1);
        if own > 0 {
            return Self(PhantomData);
        }
        let working = WORKING.lock().unwrap_or_else(PoisonError::into_inner);
        let free = ONE_IS_DONE.wait_while(working, |working| *working >= *CORES);
        *free.unwrap_or_else(PoisonError::into_inner) += 1;
        Self(PhantomData)
    }
}

impl Drop for Core {
    fn drop(&mut self) {
        OWN.set(OWN.get() - 1);
        if OWN.get() > 0 {
            return;
        }
        *WORKING.lock().unwrap_or_else(PoisonError::into_inner) -= 1;
        ONE_IS_DONE.notify_one();
    }
}
