//! A wake-up from one thread to others without a lock: a futex word.
//!
//! The waker makes one system call that never blocks; a sleeper's wait is its own sleep, to an absolute time of its clock.

use std::sync::Arc;
use std::sync::atomic::{AtomicU32, AtomicU64, Ordering};

use rustix::thread::futex;

use super::clock::Clock;

#[derive(Debug, Default)]
struct Shared {
    count: AtomicU32,
    at_ns: AtomicU64,
}

/// Shared word that counts wake-ups.
#[derive(Clone, Debug, Default)]
pub struct Wake(Arc<Shared>);

impl Wake {
    /// How many wake-ups there were so far, to be handed to [`Wake::wait_beyond`].
    #[must_use]
    pub fn count(&self) -> u32 {
        self.0.count.load(Ordering::Acquire)
    }

    /// When the last wake-up was, 0 for never.
    #[must_use]
    pub fn woken_at_ns(&self) -> u64 {
        self.0.at_ns.load(Ordering::Relaxed)
    }

    /// Wakes all sleepers, at `now_ns`.
    pub fn wake(&self, now_ns: u64) {
        self.0.at_ns.store(now_ns, Ordering::Relaxed);
        self.0.count.fetch_add(1, Ordering::Release);
        // Nobody sleeping is not an error.
        let _ = futex::wake(&self.0.count, futex::Flags::PRIVATE, i32::MAX as u32);
    }

    /// Sleeps until there have been more wake-ups than `seen`, or until `deadline_ns`. Returns the new count.
    #[must_use]
    pub fn wait_beyond(&self, clock: &dyn Clock, seen: u32, deadline_ns: u64) -> u32 {
        loop {
            let count = self.count();
            if count != seen || clock.now_ns() >= deadline_ns {
                return count;
            }
            clock.wait_on(&self.0.count, seen, deadline_ns);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::realtime::clock::{Monotonic, SECOND_NS, now_ns};

    #[test]
    fn a_wake_ends_the_wait_and_silence_reaches_the_deadline() {
        let wake = Wake::default();
        let other = wake.clone();
        let thread = std::thread::spawn(move || other.wake(now_ns()));
        assert_eq!(wake.wait_beyond(&Monotonic, 0, now_ns() + 5_000_000_000), 1);
        thread.join().expect("waker ends");
        let deadline_ns = now_ns() + 2_000_000;
        assert_eq!(wake.wait_beyond(&Monotonic, 1, deadline_ns), 1);
        assert!(now_ns() >= deadline_ns);
    }

    #[test]
    fn a_wake_reaches_every_sleeper() {
        let wake = Wake::default();
        let deadline_ns = now_ns() + 5 * SECOND_NS;
        let sleepers = [wake.clone(), wake.clone()].map(|wake| {
            std::thread::spawn(move || {
                let _ = wake.wait_beyond(&Monotonic, 0, deadline_ns);
                now_ns()
            })
        });
        std::thread::sleep(std::time::Duration::from_millis(50));
        wake.wake(now_ns());
        for sleeper in sleepers {
            assert!(sleeper.join().expect("sleeper ends") < deadline_ns);
        }
    }
}
