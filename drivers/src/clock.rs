//! The clock of every deadline and time stamp: `CLOCK_MONOTONIC`.

use rustix::time::{ClockId, Timespec, clock_gettime};

/// Nanoseconds of `CLOCK_MONOTONIC`.
#[must_use]
pub fn monotonic_ns() -> u64 {
    let now = clock_gettime(ClockId::Monotonic);
    now.tv_sec as u64 * 1_000_000_000 + now.tv_nsec as u64
}

/// Time left until `deadline_ns`, for `poll`; `None` when it has passed.
pub(crate) fn left_until(deadline_ns: u64) -> Option<Timespec> {
    let left_ns = deadline_ns
        .checked_sub(monotonic_ns())
        .filter(|&left| left > 0)?;
    Some(Timespec {
        tv_sec: (left_ns / 1_000_000_000) as _,
        tv_nsec: (left_ns % 1_000_000_000) as _,
    })
}

/// Sleeps until `deadline_ns`. Not for real-time threads.
pub(crate) fn sleep_until(deadline_ns: u64) {
    let left_ns = deadline_ns.saturating_sub(monotonic_ns());
    std::thread::sleep(std::time::Duration::from_nanos(left_ns));
}
