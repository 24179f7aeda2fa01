//! The monotonic clock, in nanoseconds, which goes on while the computer sleeps. Wall-clock time decides nothing in this process.
//!
//! What also runs on a simulated clock is given a [`Clock`]; the rest, which only runs in this process, asks here.

pub use drivers::{Clock, Monotonic, check_absolute_sleep, monotonic_ns as now_ns, slept_ns};

/// Nanoseconds in a second.
pub const SECOND_NS: u64 = 1_000_000_000;
/// Nanoseconds in a millisecond.
pub const MILLISECOND_NS: u64 = 1_000_000;

/// Sleeps until the absolute time `at_ns`; returns at once when it has passed.
pub fn sleep_until(at_ns: u64) {
    Monotonic.sleep_until(at_ns);
}
