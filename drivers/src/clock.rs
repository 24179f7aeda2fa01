//! The clock of every deadline and time stamp.

use std::fmt::Debug;
use std::num::NonZeroU32;
use std::sync::atomic::{AtomicU32, Ordering};

use rustix::thread::{clock_nanosleep_absolute, futex};
use rustix::time::{ClockId, Timespec, clock_gettime};

/// A clock that threads read and wait on: nanoseconds that never go back.
///
/// A robot has [`Monotonic`]. What runs on a simulated clock is given another one.
///
/// # Real-time contract
/// Nothing here allocates or locks; waiting is the thread's own sleep.
pub trait Clock: Debug + Send + Sync {
    /// What time it is.
    fn now_ns(&self) -> u64;

    /// Sleeps until the absolute time `at_ns`; returns at once when it has passed.
    fn sleep_until(&self, at_ns: u64);

    /// Sleeps while `word` is `seen`, until it is woken or `until_ns` has come. May wake early: the caller looks again.
    fn wait_on(&self, word: &AtomicU32, seen: u32, until_ns: u64);
}

/// `CLOCK_MONOTONIC`.
#[derive(Clone, Copy, Debug, Default)]
pub struct Monotonic;

impl Clock for Monotonic {
    fn now_ns(&self) -> u64 {
        monotonic_ns()
    }

    fn sleep_until(&self, at_ns: u64) {
        let until = timespec(at_ns);
        // The only error that can occur for a valid time is a signal: sleep on.
        while monotonic_ns() < at_ns {
            if clock_nanosleep_absolute(ClockId::Monotonic, &until).is_ok() {
                break;
            }
        }
    }

    fn wait_on(&self, word: &AtomicU32, seen: u32, until_ns: u64) {
        if word.load(Ordering::Acquire) != seen || monotonic_ns() >= until_ns {
            return;
        }
        let until = timespec(until_ns);
        // Errors are a changed word, a signal or the deadline: the caller looks again.
        let _ = futex::wait_bitset(
            word,
            futex::Flags::PRIVATE,
            seen,
            Some(&until),
            NonZeroU32::MAX,
        );
    }
}

/// Nanoseconds of `CLOCK_MONOTONIC`.
#[must_use]
pub fn monotonic_ns() -> u64 {
    let now = clock_gettime(ClockId::Monotonic);
    now.tv_sec as u64 * 1_000_000_000 + now.tv_nsec as u64
}

/// Time left until `deadline_ns` on `CLOCK_MONOTONIC`, for `poll`; `None` when it has passed.
pub(crate) fn left_until(deadline_ns: u64) -> Option<Timespec> {
    let left_ns = deadline_ns
        .checked_sub(monotonic_ns())
        .filter(|&left| left > 0)?;
    Some(timespec(left_ns))
}

fn timespec(ns: u64) -> Timespec {
    Timespec {
        tv_sec: (ns / 1_000_000_000) as _,
        tv_nsec: (ns % 1_000_000_000) as _,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const MILLISECOND_NS: u64 = 1_000_000;

    #[test]
    fn sleeping_never_ends_early() {
        let until = monotonic_ns() + 3 * MILLISECOND_NS;
        Monotonic.sleep_until(until);
        assert!(monotonic_ns() >= until);
        Monotonic.sleep_until(0);
    }

    #[test]
    fn waiting_ends_at_its_deadline_and_at_once_when_the_word_has_changed() {
        let word = AtomicU32::new(1);
        let until = monotonic_ns() + 3 * MILLISECOND_NS;
        while monotonic_ns() < until {
            Monotonic.wait_on(&word, 1, until);
        }
        Monotonic.wait_on(&word, 0, u64::MAX);
        Monotonic.wait_on(&word, 1, 0);
    }
}
