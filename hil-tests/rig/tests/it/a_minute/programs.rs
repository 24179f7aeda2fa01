//! What real-time threads promise (README, "The house"), of a robot that drives for a minute.

use std::fs;
use std::time::Duration;

use onboard::realtime::latency;

use crate::programs::bench::Bench;
use crate::programs::figures::added;
use crate::programs::late::once_more_if_late;

const MINUTE: Duration = Duration::from_secs(60);
/// A thread has all its pages before it drives. Few come later, once each: code that is run for the first time on a machine that loads
/// programs page by page.
const MOST_FAULTS: u64 = 10;

/// The guards end a robot of which a real-time thread allocates, or makes a system call that is not its own: [`Bench::finish`] says that
/// they were armed, and that it ended well.
#[test]
fn for_a_minute_no_real_time_thread_allocates_makes_a_foreign_system_call_or_waits_for_a_page() {
    once_more_if_late(|| {
        let mut bench = Bench::driving_for_long();
        let before = bench.threads();
        let way_m = bench.truth().distance_m;
        std::thread::sleep(MINUTE);
        assert!(bench.truth().distance_m > way_m + 1.0, "it has not driven");
        if latency::may_forbid().is_ok() {
            assert!(demands_awake_cores(bench.process().id()));
        }
        let locked = !bench.log().contains("memory is not");
        if !locked {
            println!("page faults are not judged: memory cannot be locked here");
        }
        for thread in added(&before, &bench.threads()) {
            // The lidar has a cycle for each scan, communication for each message.
            let least = match thread.name.as_str() {
                "communication" => 0,
                "lidar" => 500,
                _ => 1_000,
            };
            assert!(thread.cycles > least, "{thread:?}");
            let faults_count = locked && thread.is_real_time;
            assert!(
                !faults_count || thread.page_faults <= MOST_FAULTS,
                "{thread:?}"
            );
        }
        bench.finish();
    });
}

/// The kernel keeps cores out of deep sleeps as long as the robot has this file open.
fn demands_awake_cores(process: u32) -> bool {
    let files = fs::read_dir(format!("/proc/{process}/fd")).expect("it runs");
    { files.flatten() }
        .filter_map(|file| fs::read_link(file.path()).ok())
        .any(|target| target.as_os_str() == latency::DEVICE)
}
