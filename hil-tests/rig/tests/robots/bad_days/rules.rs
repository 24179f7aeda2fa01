//! What real-time threads promise (DESIGN, "Threads"), of a robot that drives for a minute.

use std::time::Duration;

use serde_json::Value as Json;

use crate::bad_days::bench::{Bench, ROBOT, onboard, said};
use crate::late::once_more_if_late;

const MINUTE: Duration = Duration::from_secs(60);
/// A thread has all its pages before it drives. Few come later, once each: code that is run for the first time on a machine that loads
/// programs page by page.
const MOST_FAULTS: u64 = 10;

/// The guards end a robot of which a real-time thread allocates, or makes a system call that is not its own: [`Bench::finish`] says that
/// they were armed, and that it ended well.
#[test]
fn for_a_minute_no_real_time_thread_allocates_makes_a_foreign_system_call_or_waits_for_a_page() {
    once_more_if_late(|| {
        let bench = Bench::driving();
        let before = threads(&bench);
        let way_m = bench.truth().distance_m;
        std::thread::sleep(MINUTE);
        let after = threads(&bench);
        assert!(bench.truth().distance_m > way_m + 1.0, "it has not driven");
        let locked = !bench.log().contains("memory is not");
        for (before, after) in before.iter().zip(&after) {
            let name = after["model"].as_str().expect("a name");
            let of = |thread: &Json, what: &str| {
                thread["value"][what]
                    .as_u64()
                    .unwrap_or_else(|| panic!("{name}: {thread}"))
            };
            let cycles = of(after, "cycles") - of(before, "cycles");
            let least = if name == "lidar" { 500 } else { 1_000 };
            assert!(
                name == "communication" || cycles > least,
                "{name}: {cycles} cycles"
            );
            let is_real_time = after["value"]["granted"]["policy"] == "fifo";
            if locked && is_real_time {
                let faults = of(after, "page_faults") - of(before, "page_faults");
                assert!(faults <= MOST_FAULTS, "{name}: {faults} page faults");
            }
        }
        bench.finish();
    });
}

/// What its threads report.
fn threads(bench: &Bench) -> Vec<Json> {
    let runtime = bench.runtime_folder();
    let runtime = runtime.to_str().expect("a plain path");
    let output = onboard(&[
        "inspect",
        "thread_report",
        "--json",
        "--robot",
        ROBOT,
        "--runtime",
        runtime,
    ]);
    assert!(output.status.success(), "{}", said(&output));
    let seen: Json = serde_json::from_slice(&output.stdout).expect("JSON");
    let symbols = seen["symbols"].as_array().expect("a list").iter();
    let reports = symbols.filter(|symbol| symbol["datatype"] == "thread_report");
    reports.cloned().collect()
}
