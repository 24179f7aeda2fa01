//! The clock of every deadline and time stamp.

use std::fmt::Debug;
use std::num::NonZeroU32;
use std::ptr::null_mut;
use std::sync::atomic::{AtomicU32, Ordering};

use rustix::thread::futex;
use rustix::time::{ClockId, Timespec, clock_gettime};

/// A clock that threads read and wait on: nanoseconds that never go back, and go on while the computer sleeps.
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

/// `CLOCK_BOOTTIME`. `CLOCK_MONOTONIC` stands still while the computer sleeps: what was heard hours ago would be new when it wakes.
#[derive(Clone, Copy, Debug, Default)]
pub struct Monotonic;

impl Clock for Monotonic {
    fn now_ns(&self) -> u64 {
        monotonic_ns()
    }

    fn sleep_until(&self, at_ns: u64) {
        // The only error that can occur for a valid time is a signal: sleep on.
        while monotonic_ns() < at_ns && !sleep_absolute(at_ns) {}
    }

    fn wait_on(&self, word: &AtomicU32, seen: u32, until_ns: u64) {
        if word.load(Ordering::Acquire) != seen || monotonic_ns() >= until_ns {
            return;
        }
        // The kernel wakes by the clock that stands still. It is read first, so that who is held up in between wakes early, not late.
        let awake_ns = ns(clock_gettime(ClockId::Monotonic));
        let until = timespec(awake_ns.saturating_add(until_ns.saturating_sub(monotonic_ns())));
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

/// The C library's sleep to an absolute time; `false` when a signal ended it.
///
/// Not rustix's: on 32-bit kernels before 5.1, which lack the call with 64 bits of time, that one sleeps for as long as the
/// computer has been running. The C library asks such kernels with 32 bits, which count seconds since the start for 68 years.
fn sleep_absolute(at_ns: u64) -> bool {
    let until = libc::timespec {
        tv_sec: libc::time_t::try_from(at_ns / 1_000_000_000).unwrap_or(libc::time_t::MAX),
        tv_nsec: (at_ns % 1_000_000_000) as _,
    };
    // SAFETY: `until` outlives the call, and nothing asks for the time that is left.
    let result = unsafe {
        libc::clock_nanosleep(
            libc::CLOCK_BOOTTIME,
            libc::TIMER_ABSTIME,
            &raw const until,
            null_mut(),
        )
    };
    result == 0
}

/// Whether this kernel sleeps to absolute times, as every period of a real-time thread asks it to: it is asked for one that has
/// long passed, which takes no time, or 20 ms where the kernel counts from now.
///
/// # Errors
/// [`RelativeSleep`] when that took as long as the time says, three times.
pub fn check_absolute_sleep() -> Result<(), RelativeSleep> {
    check_sleep(|at_ns| {
        sleep_absolute(at_ns);
    })
}

/// A kernel, or a library, that takes an absolute time for a duration.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error(
    "a sleep until {PASSED_MS} ms after the start of the computer lasts that long, hours later: the kernel takes absolute times for \
     durations, and no thread can keep a period; expected Linux 5.1 or newer"
)]
pub struct RelativeSleep;

const PASSED_MS: u64 = 20;

fn check_sleep(sleep_until: impl Fn(u64)) -> Result<(), RelativeSleep> {
    const TRIES: usize = 3;
    // A computer that has just started: that time is still to come.
    while monotonic_ns() < 2 * PASSED_MS * 1_000_000 {
        std::thread::yield_now();
    }
    // Who is held up by the machine is not held up each time.
    let at_once = (0..TRIES).any(|_| {
        let begin_ns = monotonic_ns();
        sleep_until(PASSED_MS * 1_000_000);
        monotonic_ns() - begin_ns < PASSED_MS * 1_000_000
    });
    at_once.then_some(()).ok_or(RelativeSleep)
}

/// Nanoseconds of `CLOCK_BOOTTIME`.
#[must_use]
pub fn monotonic_ns() -> u64 {
    ns(clock_gettime(ClockId::Boottime))
}

/// How long this computer has slept since it was switched on, as far as its kernel knows. Where the thread is held up while it looks,
/// that is too little by so long, and never too much.
#[must_use]
pub fn slept_ns() -> u64 {
    let since_start_ns = monotonic_ns();
    since_start_ns.saturating_sub(ns(clock_gettime(ClockId::Monotonic)))
}

/// Time left until `deadline_ns` on `CLOCK_BOOTTIME`, for `poll`; `None` when it has passed.
pub(crate) fn left_until(deadline_ns: u64) -> Option<Timespec> {
    let left_ns = deadline_ns
        .checked_sub(monotonic_ns())
        .filter(|&left| left > 0)?;
    Some(timespec(left_ns))
}

fn ns(time: Timespec) -> u64 {
    time.tv_sec as u64 * 1_000_000_000 + time.tv_nsec as u64
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

    /// As the kernel counts it for people, in hundredths of a second.
    #[test]
    fn the_clock_goes_on_while_the_computer_sleeps() {
        let uptime_ns = || {
            let text = std::fs::read_to_string("/proc/uptime").expect("the kernel tells");
            let seconds = text.split(' ').next().map(str::parse::<f64>);
            (seconds.expect("two numbers").expect("a number") * 1e9) as u64
        };
        let (before_ns, now_ns, after_ns) = (uptime_ns(), monotonic_ns(), uptime_ns());
        let between = before_ns..=after_ns + 20 * MILLISECOND_NS;
        assert!(between.contains(&now_ns), "{now_ns}, {between:?}");
        let awake_ns = ns(clock_gettime(ClockId::Monotonic));
        assert!(slept_ns() <= monotonic_ns() - awake_ns);
    }

    /// In a time namespace, as on a computer that has slept for a day: where this process may have one.
    #[test]
    fn waits_are_as_long_on_a_computer_that_has_slept() {
        let this = std::env::current_exe().expect("it runs");
        let output = std::process::Command::new("unshare")
            .args(["--time", "--boottime", "86400"])
            .arg(this)
            .args(["--ignored", "--exact", "clock::tests::has_slept_for_a_day"])
            .output();
        let Ok(output) = output else {
            return println!("skipped: there is no `unshare`");
        };
        let (said, error) = [&output.stdout, &output.stderr]
            .map(|bytes| String::from_utf8_lossy(bytes).into_owned())
            .into();
        if !said.contains("running 1 test") {
            return println!("skipped: {error}");
        }
        assert!(output.status.success(), "{said}{error}");
    }

    #[test]
    #[ignore = "the test above runs it where the clocks differ"]
    fn has_slept_for_a_day() {
        const DAY_NS: u64 = 86_400_000_000_000;
        std::thread::spawn(|| {
            std::thread::sleep(std::time::Duration::from_secs(20));
            eprintln!("it waits for the clock that stood still");
            std::process::exit(1);
        });
        assert!((DAY_NS - 1_000 * MILLISECOND_NS..=DAY_NS).contains(&slept_ns()));
        let began_ns = monotonic_ns();
        let (word, until_ns) = (AtomicU32::new(1), began_ns + 5 * MILLISECOND_NS);
        while monotonic_ns() < until_ns {
            Monotonic.wait_on(&word, 1, until_ns);
        }
        Monotonic.sleep_until(until_ns + 5 * MILLISECOND_NS);
        let took_ns = monotonic_ns() - began_ns;
        assert!((10 * MILLISECOND_NS..5_000 * MILLISECOND_NS).contains(&took_ns));
        assert_eq!(check_absolute_sleep(), Ok(()));
    }

    #[test]
    fn a_sleep_that_counts_from_now_is_refused() {
        assert_eq!(check_absolute_sleep(), Ok(()));
        let relative = |at_ns| std::thread::sleep(std::time::Duration::from_nanos(at_ns));
        assert_eq!(check_sleep(relative), Err(RelativeSleep));
    }

    #[test]
    fn a_time_beyond_what_the_kernel_counts_is_far_away() {
        // As far as the C library and the kernel go: the thread sleeps, and is left to.
        let sleeper = std::thread::spawn(|| Monotonic.sleep_until(u64::MAX));
        std::thread::sleep(std::time::Duration::from_millis(20));
        assert!(!sleeper.is_finished());
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
