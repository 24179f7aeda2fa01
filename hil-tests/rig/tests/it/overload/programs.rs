//! The computer has more to do than it has time for, as the robots of other tests would have: these have none beside them. Or its disk or
//! its network hangs.

use std::sync::atomic::Ordering;
use std::time::{Duration, Instant};

use rig::bench::place::{Place, cores};
use rig::threads::Threads;

use crate::programs::bench::Bench;
use crate::programs::figures::{
    LATE_ALONE_US, LATE_BESIDE_OTHERS_US, all_are_punctual, all_keep_their_time,
};
use crate::programs::held::HeldThread;
use crate::programs::late::once_more_if_late;
use crate::programs::watch::SURELY_STANDS;

/// Above all threads of robots and devices.
const ABOVE_ALL: u8 = 98;
/// Threads late beyond measure show within a second, and twice more, or cost the bus at once.
const STOPS_WITHIN: Duration = Duration::from_secs(6);

/// Threads that work, one on each core, until they are dropped: each for a while, and rests for a while; with a priority of its own, or
/// with that of everybody.
fn hogs(priority: Option<u8>, works: Duration, rests: Duration) -> Threads {
    let mut hogs = Threads::default();
    for core in cores() {
        let hog = hogs.spawn("hog".to_owned(), move |stop| {
            // Without the right to a priority it is one hog more of the other kind.
            let _ = Place { priority, core }.take();
            while !stop.load(Ordering::Relaxed) {
                let begun = Instant::now();
                while begun.elapsed() < works {
                    std::hint::spin_loop();
                }
                std::thread::sleep(rests);
            }
        });
        hog.expect("a thread");
    }
    hogs
}

/// Whatever it has latched.
fn goes_on(bench: &mut Bench) {
    let began = Instant::now();
    while !bench.ctl("reset").status.success() {
        assert!(began.elapsed() < Duration::from_secs(10));
        std::thread::sleep(Duration::from_millis(200));
    }
    bench.until_driving();
}

#[test]
fn work_of_others_on_the_same_cores_does_not_hold_it_up() {
    once_more_if_late(|| {
        let mut bench = Bench::driving_alone();
        bench.until_fast();
        let before = bench.threads();
        let hogs = hogs(None, Duration::from_secs(1), Duration::ZERO);
        bench.drives_for(Duration::from_secs(5));
        assert!(!bench.publishes("overruns") && !bench.publishes("command-stale"));
        let after = bench.threads();
        all_keep_their_time(&before, &after);
        all_are_punctual(&before, &after, LATE_ALONE_US);
        drop(hogs);
        bench.finish();
    });
}

#[test]
fn one_that_gets_no_time_stops_and_goes_on_after_a_reset_when_it_has_time_again() {
    once_more_if_late(|| {
        let mut bench = Bench::driving_alone();
        bench.until_fast();
        // A fifth of the time is left.
        let [works, rests] = [40, 10].map(Duration::from_millis);
        let hogs = hogs(Some(ABOVE_ALL), works, rests);
        bench.until_standing(STOPS_WITHIN);
        bench.stands_for(Duration::from_secs(1));
        drop(hogs);
        goes_on(&mut bench);
        assert!(bench.truth().collisions == 0);
        bench.finish();
    });
}

#[test]
fn a_disk_that_hangs_costs_no_thread_its_time_and_stops_it_since_it_would_be_forgotten() {
    once_more_if_late(|| {
        let mut bench = Bench::driving();
        let before = bench.threads();
        let held = HeldThread::at_its_disk(bench.process().id(), "checkpoint");
        bench.until_published("note-unwritten", STOPS_WITHIN);
        bench.until_standing(SURELY_STANDS);
        let after = bench.threads();
        all_keep_their_time(&before, &after);
        all_are_punctual(&before, &after, LATE_BESIDE_OTHERS_US);
        drop(held);
        bench.until_driving();
        bench.finish();
    });
}

#[test]
fn a_network_that_hangs_costs_no_thread_its_time_and_stops_it_since_nobody_hears_it() {
    once_more_if_late(|| {
        let mut bench = Bench::driving();
        let before = bench.threads();
        let held = HeldThread::of(bench.process().id(), "communication");
        bench.until_standing(STOPS_WITHIN);
        bench.stands_for(Duration::from_secs(1));
        let after = bench.threads();
        all_keep_their_time(&before, &after);
        all_are_punctual(&before, &after, LATE_BESIDE_OTHERS_US);
        drop(held);
        goes_on(&mut bench);
        bench.finish();
    });
}
