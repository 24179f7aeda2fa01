//! Tests of robots in real time, on a machine that sometimes keeps threads from their time.

use std::cell::Cell;
use std::panic::{catch_unwind, resume_unwind};
use std::sync::OnceLock;
use std::time::Duration;

use rig::stalls::StallWatch;
use sim::rt::monotonic_ns;

/// What a supervisor logs when real-time threads miss their periods.
const SLOWED_DOWN: &str = "overruns: driving at half speed";
/// A stall this long costs a robot what it judges itself by: frames, setpoints, scans.
const SPOILS_MS: f64 = 15.0;
/// A test is repeated at most so often, each time when the machine has been quiet for a while, or has had time to be.
const REPETITIONS: u32 = 2;
const QUIET: Duration = Duration::from_secs(2);
const QUIET_STALLS: usize = 5;
const MOST_WAITS: u32 = 20;

thread_local! {
    static SLOWED: Cell<bool> = const { Cell::new(false) };
}

/// Takes note of the log of a robot whose test has failed.
pub fn note(log: &str) {
    SLOWED.set(SLOWED.get() || log.contains(SLOWED_DOWN));
}

/// Runs a test, and once more when it failed while the machine stalled or its robot slowed down because threads were late; twice
/// where that was spoiled too.
pub fn once_more_if_late(test: fn()) {
    static WATCH: OnceLock<StallWatch> = OnceLock::new();
    let watch = WATCH.get_or_init(|| StallWatch::start().expect("threads"));
    for _ in 0..REPETITIONS {
        let start_ns = monotonic_ns();
        SLOWED.set(false);
        let Err(cause) = catch_unwind(test) else {
            return;
        };
        let stalls = watch.since(start_ns);
        if !SLOWED.get() && stalls.longest_ms < SPOILS_MS {
            resume_unwind(cause);
        }
        eprintln!(
            "spoiled by the machine, which stalled {} times, {:.0} ms at most: once more",
            stalls.count, stalls.longest_ms
        );
        wait_for_quiet(watch);
    }
    test();
}

fn wait_for_quiet(watch: &StallWatch) {
    for _ in 0..MOST_WAITS {
        let since_ns = monotonic_ns();
        std::thread::sleep(QUIET);
        if watch.since(since_ns).count < QUIET_STALLS {
            return;
        }
    }
}

#[test]
fn a_test_whose_robot_slowed_down_runs_once_more() {
    thread_local! {
        static RUNS: Cell<u32> = const { Cell::new(0) };
    }
    once_more_if_late(|| {
        RUNS.set(RUNS.get() + 1);
        if RUNS.get() == 1 {
            note("WARN thread fieldbus overruns: driving at half speed");
            panic!("on purpose");
        }
    });
    assert_eq!(RUNS.get(), 2);
    once_more_if_late(|| {
        RUNS.set(RUNS.get() + 1);
        if RUNS.get() < 5 {
            note("WARN thread fieldbus overruns: driving at half speed");
            panic!("on purpose");
        }
    });
    assert_eq!(RUNS.get(), 5);
    let failed = catch_unwind(|| {
        once_more_if_late(|| {
            RUNS.set(RUNS.get() + 1);
            panic!("on purpose");
        });
    });
    assert!(failed.is_err());
}
