//! The computer has more to do than it has time for.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use rustix::thread::{CpuSet, sched_setaffinity};
use sim::rt::promote;

use crate::bad_days::bench::Bench;
use crate::late::once_more_if_late;

/// Above all threads of robots and devices.
const ABOVE_ALL: u8 = 98;
/// Threads late beyond measure show within a second, and twice more, or cost the bus at once.
const STOPS_WITHIN: Duration = Duration::from_secs(6);

/// Threads that work, one on each core, until they are dropped.
struct Hogs {
    stop: Arc<AtomicBool>,
    threads: Vec<JoinHandle<()>>,
}

impl Hogs {
    /// Each works for a while, and rests for a while; with a priority of its own, or with that of everybody.
    fn start(priority: Option<u8>, works: Duration, rests: Duration) -> Self {
        let stop = Arc::new(AtomicBool::new(false));
        let cores = std::thread::available_parallelism().map_or(1, usize::from);
        let hog = |core: usize| {
            let stop = Arc::clone(&stop);
            std::thread::spawn(move || {
                let mut own = CpuSet::new();
                own.set(core);
                let _ = sched_setaffinity(None, &own);
                let _ = priority.map(promote);
                while !stop.load(Ordering::Relaxed) {
                    let begun = Instant::now();
                    while begun.elapsed() < works {
                        std::hint::spin_loop();
                    }
                    std::thread::sleep(rests);
                }
            })
        };
        let threads = (0..cores).map(hog).collect();
        Self { stop, threads }
    }
}

impl Drop for Hogs {
    fn drop(&mut self) {
        self.stop.store(true, Ordering::Relaxed);
        for thread in self.threads.drain(..) {
            let _ = thread.join();
        }
    }
}

#[test]
fn work_of_others_on_the_same_cores_does_not_hold_it_up() {
    once_more_if_late(|| {
        let mut bench = Bench::driving();
        bench.until_fast();
        let hogs = Hogs::start(None, Duration::from_secs(1), Duration::ZERO);
        bench.drives_for(Duration::from_secs(5));
        assert!(!bench.publishes("overruns") && !bench.publishes("command-stale"));
        drop(hogs);
        bench.finish();
    });
}

#[test]
fn one_that_gets_no_time_stops_and_goes_on_after_a_reset_when_it_has_time_again() {
    once_more_if_late(|| {
        let mut bench = Bench::driving();
        bench.until_fast();
        // A fifth of the time is left.
        let [works, rests] = [40, 10].map(Duration::from_millis);
        let hogs = Hogs::start(Some(ABOVE_ALL), works, rests);
        bench.until_standing(STOPS_WITHIN);
        bench.stands_for(Duration::from_secs(1));
        drop(hogs);
        // Whatever it has latched.
        let began = Instant::now();
        while !bench.ctl("reset").status.success() {
            assert!(began.elapsed() < Duration::from_secs(10));
            std::thread::sleep(Duration::from_millis(200));
        }
        bench.until_driving();
        assert!(bench.truth().collisions == 0);
        bench.finish();
    });
}
