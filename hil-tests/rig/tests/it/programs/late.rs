//! Tests of robots in real time, on a machine that sometimes keeps threads from their time.

use std::cell::Cell;
use std::io::Write;
use std::panic::{RefUnwindSafe, catch_unwind, resume_unwind};
use std::sync::OnceLock;
use std::time::Duration;

use rig::stalls::{StallWatch, Stalls};
use rig::violation::ViolationKind;
use serde::Deserialize as _;
use serde_json::Value as Json;
use sim::rt::monotonic_ns;

/// What a supervisor logs when real-time threads miss their periods.
const SLOWED_DOWN: &str = "overruns: driving at half speed";
/// What a program says that one of its guards has ended.
const GUARDS: [&str; 2] = ["allocation guard: ", "guard of system calls: "];
/// A test is repeated when the machine has been quiet for so long, or has had time to be.
const QUIET: Duration = Duration::from_secs(2);
const QUIET_STALLS: usize = 5;
const MOST_WAITS: u32 = 20;

thread_local! {
    static SLOWED: Cell<bool> = const { Cell::new(false) };
    /// A simulated device was late.
    static DEVICE: Cell<bool> = const { Cell::new(false) };
    /// Something happened for which no stall is an excuse.
    static UNSAFE: Cell<bool> = const { Cell::new(false) };
    /// When the test of this thread had its last turn.
    static TURN_NS: Cell<u64> = const { Cell::new(0) };
}

/// Takes note of the log of a robot whose test has failed.
pub fn note(log: &str) {
    if log.contains(SLOWED_DOWN) {
        note_late();
    }
    if GUARDS.iter().any(|guard| log.contains(guard)) {
        note_unsafe();
    }
}

/// Threads of a robot were late.
pub fn note_late() {
    SLOWED.set(true);
}

/// Takes note of the turns that a simulated lidar missed because its own thread was not run: no robot has a part in that.
pub fn note_missed_turns(turns: u64) {
    if turns > 0 {
        DEVICE.set(true);
    }
}

/// The test of this thread has its turn: how the machine stalled while it waited, minutes perhaps, is no excuse for what comes now.
pub fn note_turn() {
    TURN_NS.set(monotonic_ns());
}

/// Whatever the machine did: this test is not repeated, should it fail.
pub fn note_unsafe() {
    UNSAFE.set(true);
}

/// Asserts what must hold whatever the machine does.
#[track_caller]
pub fn safe(holds: bool, what: impl FnOnce() -> String) {
    if !holds {
        note_unsafe();
        panic!("unsafe: {}", what());
    }
}

/// Takes note of the violations of a run, as its summary lists them.
pub fn note_violations(summary: &Json) {
    let violations = summary["violations"].as_array().into_iter().flatten();
    let kinds = violations.filter_map(|own| ViolationKind::deserialize(&own["kind"]).ok());
    note_kinds(kinds);
}

/// The same of the kinds of violations.
pub fn note_kinds(mut kinds: impl Iterator<Item = ViolationKind>) {
    if kinds.any(|kind| !kind.may_come_of_a_stall()) {
        note_unsafe();
    }
}

/// Runs a test, and once more when it failed while the machine stalled, since it had its last turn.
pub fn once_more_if_late(test: impl Fn() + RefUnwindSafe) {
    static WATCH: OnceLock<StallWatch> = OnceLock::new();
    let watch = WATCH.get_or_init(|| StallWatch::start().expect("threads"));
    let since = |start_ns| watch.since(start_ns);
    once_more(test, since, || wait_for_quiet(watch));
}

/// The same, with stalls from elsewhere since a time.
fn once_more(
    test: impl Fn() + RefUnwindSafe,
    since: impl Fn(u64) -> Stalls,
    wait_for_quiet: impl Fn(),
) {
    let start_ns = monotonic_ns();
    SLOWED.set(false);
    DEVICE.set(false);
    UNSAFE.set(false);
    let Err(cause) = catch_unwind(&test) else {
        return;
    };
    let stalls = since(start_ns.max(TURN_NS.get()));
    if UNSAFE.get() || !is_excused(&stalls) {
        resume_unwind(cause);
    }
    let thread = std::thread::current();
    let name = thread.name().unwrap_or("a test");
    // Not by a macro, whose words nobody sees where the repetition passes.
    let device = if DEVICE.get() {
        ", and the simulated lidar missed a turn"
    } else {
        ""
    };
    let _ = writeln!(
        std::io::stderr(),
        "{name}: spoiled, {stalls}{device}; once more"
    );
    wait_for_quiet();
    test();
}

/// Whether the machine may be to blame: it stalled for long, or kept a simulated device from its time, or it stalled and threads of the
/// robot were late. Late threads of a robot alone are no excuse: they may be the robot's own fault.
fn is_excused(stalls: &Stalls) -> bool {
    stalls.spoil() || DEVICE.get() || SLOWED.get() && stalls.count > 0
}

fn wait_for_quiet(watch: &StallWatch) {
    for _ in 0..MOST_WAITS {
        let since_ns = monotonic_ns();
        std::thread::sleep(QUIET);
        let stalls = watch.since(since_ns);
        if stalls.count < QUIET_STALLS && !stalls.spoil() {
            return;
        }
    }
}

thread_local! {
    static RUNS: Cell<u32> = const { Cell::new(0) };
}

/// How often a test was run that always fails, by a robot that slows down or not, with these stalls.
fn runs(slows_down: bool, count: usize, longest_ms: f64) -> u32 {
    RUNS.set(0);
    let stalls = Stalls {
        count,
        longest_ms,
        ..Stalls::default()
    };
    let fails = || {
        RUNS.set(RUNS.get() + 1);
        panic!("on purpose");
    };
    let slows = || {
        RUNS.set(RUNS.get() + 1);
        note("WARN thread fieldbus overruns: driving at half speed");
        panic!("on purpose");
    };
    let test: fn() = if slows_down { slows } else { fails };
    let failed = catch_unwind(|| once_more(test, |_| stalls, || {}));
    assert!(failed.is_err());
    RUNS.get()
}

#[test]
fn a_test_that_a_stall_spoiled_runs_once_more() {
    assert_eq!(runs(false, 0, 0.0), 1);
    assert_eq!(runs(true, 0, 0.0), 1, "late threads alone");
    assert_eq!(runs(false, 3, 14.0), 1, "short stalls alone");
    assert_eq!(runs(true, 1, 6.0), 2);
    assert_eq!(runs(false, 1, 15.0), 2);
    RUNS.set(0);
    let recovers = || {
        RUNS.set(RUNS.get() + 1);
        assert!(RUNS.get() > 1, "on purpose");
    };
    let long = |_| Stalls {
        count: 1,
        longest_ms: 20.0,
        ..Stalls::default()
    };
    once_more(recovers, long, || {});
    assert_eq!(RUNS.get(), 2);
}

#[test]
fn a_stall_while_a_test_waited_for_its_turn_is_no_excuse() {
    thread_local! {
        static STALLED_NS: Cell<u64> = const { Cell::new(0) };
    }
    fn runs_of(test: fn()) -> u32 {
        RUNS.set(0);
        let since = |start_ns: u64| {
            let count = usize::from(STALLED_NS.get() >= start_ns);
            Stalls {
                count,
                longest_ms: 20.0 * count as f64,
                ..Stalls::default()
            }
        };
        let failed = catch_unwind(|| once_more(test, since, || {}));
        assert!(failed.is_err());
        RUNS.get()
    }
    fn stalls() {
        STALLED_NS.set(monotonic_ns());
        std::thread::sleep(Duration::from_millis(1));
    }
    fn has_its_turn() {
        RUNS.set(RUNS.get() + 1);
        note_turn();
    }
    let waited = || {
        stalls();
        has_its_turn();
        panic!("on purpose");
    };
    assert_eq!(runs_of(waited), 1);
    let had_its_turn = || {
        has_its_turn();
        stalls();
        panic!("on purpose");
    };
    assert_eq!(runs_of(had_its_turn), 2);
    // A turn of another test, on the same thread, was before this one.
    let has_none = || {
        RUNS.set(RUNS.get() + 1);
        stalls();
        panic!("on purpose");
    };
    assert_eq!(runs_of(has_none), 2);
}

#[test]
fn a_test_whose_simulated_lidar_was_late_runs_once_more() {
    fn runs_of(turns: u64) -> u32 {
        RUNS.set(0);
        let test = || {
            RUNS.set(RUNS.get() + 1);
            note_missed_turns(turns);
            panic!("on purpose");
        };
        let failed = catch_unwind(|| once_more(test, |_| Stalls::default(), || {}));
        assert!(failed.is_err());
        RUNS.get()
    }
    assert_eq!(runs_of(2), 2);
    assert_eq!(runs_of(0), 1, "the one before was another test");
}

#[test]
fn a_test_that_failed_by_what_is_unsafe_runs_once() {
    fn runs_of(test: fn()) -> u32 {
        RUNS.set(0);
        let long = |_| Stalls {
            count: 1,
            longest_ms: 20.0,
            ..Stalls::default()
        };
        let failed = catch_unwind(|| once_more(test, long, || {}));
        assert!(failed.is_err());
        RUNS.get()
    }
    fn began() {
        RUNS.set(RUNS.get() + 1);
    }
    fn violated(kind: &str) {
        began();
        note_violations(&serde_json::json!({ "violations": [{ "kind": kind }] }));
        panic!("on purpose");
    }
    assert_eq!(runs_of(|| violated("clearance")), 2, "it braked late");
    assert_eq!(runs_of(|| violated("collision")), 1);
    assert_eq!(runs_of(|| violated("two-owners")), 1);
    let by_an_assertion = || {
        began();
        safe(false, || "on purpose".to_owned());
    };
    assert_eq!(runs_of(by_an_assertion), 1);
    let by_a_guard = || {
        began();
        note("allocation guard: a real-time thread allocated 8 bytes in state running");
        panic!("on purpose");
    };
    assert_eq!(runs_of(by_a_guard), 1);
}
