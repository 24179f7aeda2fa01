//! The monotonic clock, in nanoseconds. Wall-clock time decides nothing in this process.

use rustix::thread::clock_nanosleep_absolute;
use rustix::time::{ClockId, Timespec, clock_gettime};

/// Nanoseconds in a second.
pub const SECOND_NS: u64 = 1_000_000_000;
/// Nanoseconds in a millisecond.
pub const MILLISECOND_NS: u64 = 1_000_000;

/// Now, on `CLOCK_MONOTONIC`.
#[must_use]
pub fn now_ns() -> u64 {
    let time = clock_gettime(ClockId::Monotonic);
    time.tv_sec as u64 * SECOND_NS + time.tv_nsec as u64
}

/// `at_ns` as the kernel's time structure.
#[must_use]
pub fn timespec(at_ns: u64) -> Timespec {
    Timespec {
        tv_sec: (at_ns / SECOND_NS) as _,
        tv_nsec: (at_ns % SECOND_NS) as _,
    }
}

/// Sleeps until the absolute time `at_ns`; returns at once when it has passed.
pub fn sleep_until(at_ns: u64) {
    let until = timespec(at_ns);
    // The only error that can occur for a valid time is a signal: sleep on.
    while now_ns() < at_ns {
        if clock_nanosleep_absolute(rustix::time::ClockId::Monotonic, &until).is_ok() {
            break;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sleeping_never_ends_early() {
        let until = now_ns() + 3 * MILLISECOND_NS;
        sleep_until(until);
        assert!(now_ns() >= until);
        sleep_until(0);
    }
}
