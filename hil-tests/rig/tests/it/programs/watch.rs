//! Waits for what becomes true, and judges it by the world's log.

use std::os::unix::process::ExitStatusExt;
use std::time::{Duration, Instant};

use rustix::process::Signal;
use sim::rt::monotonic_ns;
use sim::world::Truth;

use crate::programs::bench::Bench;
use crate::programs::late::safe;

const LOOK: Duration = Duration::from_millis(10);
/// A robot that starts brings its bus up, connects its lidar and sees 2 s of good scans; so does one that goes on.
const PATIENCE: Duration = Duration::from_secs(15);
/// Faster than this it drives.
const DRIVING_M_S: f64 = 0.12;
/// Slower than this it stands.
const STANDING_M_S: f64 = 0.01;
/// How long it must do either to be believed.
const STEADY: Duration = Duration::from_millis(300);
/// Half speed, where threads were late, is over by then.
const FAST_WITHIN: Duration = Duration::from_secs(20);
/// The last link of the chain is at rest after this time, whatever happened: the drive's watchdog, then friction.
pub const SURELY_STANDS: Duration = Duration::from_millis(1500);

pub fn seconds(time_ns: u64) -> f64 {
    time_ns as f64 / 1e9
}

impl Bench {
    /// What is true now.
    pub fn truth(&self) -> Truth {
        let mut world = self.world.lock();
        world.advance_to(monotonic_ns());
        world.truth(0).expect("there is one robot")
    }

    /// What was true since a time, 50 times a second.
    pub fn since(&self, start_ns: u64) -> Vec<Truth> {
        let mut world = self.world.lock();
        world.advance_to(monotonic_ns());
        let records = world.log().records().map(|record| record.truth);
        records.filter(|truth| truth.time_ns >= start_ns).collect()
    }

    /// Waits until something holds.
    pub fn until(&mut self, what: &str, patience: Duration, mut holds: impl FnMut(&Self) -> bool) {
        let began = Instant::now();
        while !holds(self) {
            assert!(
                began.elapsed() < patience,
                "not within {patience:?}: {what}; published: {:?}",
                self.published()
            );
            if let Some(status) = self.robot.as_mut().and_then(|robot| robot.poll()) {
                // One that was killed on purpose is watched until it stands.
                let killed = status.signal() == Some(Signal::KILL.as_raw());
                assert!(killed, "{what}: the robot ended with {status}");
            }
            std::thread::sleep(LOOK);
        }
    }

    /// Waits until it drives steadily, and not forever.
    pub fn until_driving(&mut self) {
        let mut since = Instant::now();
        self.until("it drives", PATIENCE, |bench| {
            if bench.truth().twist.v_m_s < DRIVING_M_S {
                since = Instant::now();
            }
            since.elapsed() > STEADY
        });
    }

    /// Waits until it drives almost as fast as it may.
    pub fn until_fast(&mut self) {
        self.until("full speed", FAST_WITHIN, |bench| {
            bench.truth().twist.v_m_s > 0.33
        });
    }

    /// Waits until it publishes that this fault is present.
    pub fn until_published(&mut self, fault: &str, patience: Duration) {
        self.until("the fault is published", patience, |bench| {
            bench.publishes(fault)
        });
    }

    /// Waits until it stands, which must be the case within a time from now on.
    pub fn until_standing(&mut self, within: Duration) {
        let mut since = Instant::now();
        self.until("it stands", within + STEADY, |bench| {
            if bench.truth().twist.v_m_s.abs() > STANDING_M_S {
                since = Instant::now();
            }
            since.elapsed() > STEADY
        });
    }

    /// Lets time pass in which it must stand.
    pub fn stands_for(&self, time: Duration) {
        let before = self.truth();
        std::thread::sleep(time);
        let after = self.truth();
        let way_m = after.distance_m - before.distance_m;
        assert!(way_m < 0.01, "moved {way_m:.3} m in {time:?}");
    }

    /// Lets time pass in which it must drive all the time.
    pub fn drives_for(&self, time: Duration) {
        let start_ns = monotonic_ns();
        std::thread::sleep(time);
        let slowest = self
            .since(start_ns)
            .into_iter()
            .min_by(|a, b| a.twist.v_m_s.total_cmp(&b.twist.v_m_s))
            .expect("the world goes on");
        assert!(
            slowest.twist.v_m_s > DRIVING_M_S,
            "slowed down: {slowest:?}"
        );
    }

    /// The same; returns how fast it was at most.
    pub fn fastest_m_s(&self, time: Duration) -> f64 {
        let start_ns = monotonic_ns();
        self.drives_for(time);
        let speeds = { self.since(start_ns).into_iter() }.map(|truth| truth.twist.v_m_s);
        speeds.fold(0.0, f64::max)
    }

    /// It stops by what `happens`, and in time: as [`Self::stopped_in_time`] judges.
    pub fn is_stopped(&mut self, delay: Duration, happens: impl FnOnce(&Self)) {
        let start_ns = monotonic_ns();
        happens(self);
        self.until_standing(SURELY_STANDS);
        self.stopped_in_time(start_ns, delay);
    }

    /// Judges a stop: `delay` after `start_ns` the command was invalid and that was noticed, and from then on the true
    /// speed has been under `v0 - a_stop * t`, with a tenth of tolerance and a little slack for a busy machine.
    pub fn stopped_in_time(&self, start_ns: u64, delay: Duration) {
        const SLACK_S: f64 = 0.2;
        const FLOOR_M_S: f64 = 0.02;
        let log = self.since(start_ns);
        // It may have been accelerating until then.
        let until_ns = start_ns + u64::try_from(delay.as_nanos()).expect("short");
        let start_m_s = log
            .iter()
            .filter(|truth| truth.time_ns <= until_ns)
            .map(|truth| truth.twist.v_m_s)
            .fold(0.0, f64::max);
        let deceleration_m_s2 = 0.9 * self.config.drive.limits.stop_deceleration_m_s2;
        for truth in log {
            let after_s = seconds(truth.time_ns - start_ns) - delay.as_secs_f64() - SLACK_S;
            let limit_m_s = start_m_s * 1.1 - deceleration_m_s2 * after_s.max(0.0);
            let speed_m_s = truth.twist.v_m_s.abs();
            safe(speed_m_s < limit_m_s.max(FLOOR_M_S), || {
                let after_s = seconds(truth.time_ns - start_ns);
                format!(
                    "{speed_m_s:.3} m/s, expected at most {limit_m_s:.3}, {after_s:.3} s after the fault"
                )
            });
        }
    }
}
