//! Watches the threads, second by second: which miss their periods, and which have stopped running.

use config::RobotConfig;
use coordination::symbols::Reader;

use description::threads::{ActivityKind, ThreadConfig};
use drivers::hokuyo::Options;

use crate::composition::plan::wanted_scheduling;
use crate::realtime::clock::SECOND_NS;
use crate::symbols::values::ThreadReport;

/// Share of a second's periods that were missed from which the robot slows down.
const DEGRADED_SHARE: f64 = 0.10;
/// Share of a second's periods that counts towards a stop.
const OVERLOADED_SHARE: f64 = 0.30;
/// Seconds in a row over that share that stop the robot.
const OVERLOADED_SECONDS: u32 = 3;
/// Fewer missed periods in a second than this are never judged: a thread with few cycles has coarse shares.
const LEAST_MISSED: u64 = 3;

/// Seconds without a cycle after which a thread that runs hangs,
const HUNG_SECONDS: u32 = 1;
/// and communication that does not run: it may be opening its network.
const OPENING_SECONDS: u32 = 10;

/// How well a thread keeps its deadlines.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Load {
    /// It keeps them.
    Fine,
    /// It misses so often that the robot slows down.
    Degraded,
    /// It misses so often that the robot stops.
    Overloaded,
    /// It has not run for a second, or, before its activities run, for longer than they may take to begin: the robot stops. Seconds are
    /// judged as a whole, so that it takes up to one more.
    Hung,
}

#[derive(Debug)]
struct Thread {
    name: String,
    report: Reader<ThreadReport>,
    /// It says something before long, if it runs at all.
    begins: bool,
    /// Its deadlines are real-time ones.
    real_time: bool,
    /// Seconds without a cycle after which it hangs, while its activities do not run.
    patience_s: u32,
    cycles: u64,
    missed: u64,
    /// Seconds in a row without a cycle.
    seconds_still: u32,
    seconds_over: u32,
    load: Load,
}

/// Watches the reports of all threads.
#[derive(Debug)]
pub struct OverrunWatch {
    threads: Vec<Thread>,
    judged_ns: u64,
    /// Which thread had the worst load, and that load.
    worst: (usize, Load),
}

impl OverrunWatch {
    /// Watches the threads of a robot, by their reports; deadlines are for those that ask for a real-time priority.
    #[must_use]
    pub fn of(robot: &RobotConfig, reports: Vec<Reader<ThreadReport>>) -> Self {
        let threads = robot.threads.iter().zip(reports).map(|(thread, report)| {
            let real_time = wanted_scheduling(thread).fifo_priority.is_some();
            Thread {
                begins: { thread.activities.iter() }
                    .any(|kind| *kind != ActivityKind::Communication),
                ..Thread::new(
                    thread.name.clone(),
                    report,
                    real_time,
                    patience_s(robot, thread),
                )
            }
        });
        Self {
            threads: threads.collect(),
            judged_ns: 0,
            worst: (0, Load::Fine),
        }
    }

    /// Once a second: the thread with the worst load, when that load has changed; if all are fine again, the one that had it.
    pub fn judge(&mut self, now_ns: u64) -> Option<(String, Load)> {
        if now_ns < self.judged_ns + SECOND_NS {
            return None;
        }
        self.judged_ns = now_ns;
        for thread in &mut self.threads {
            let read = thread.report.read();
            // One that hangs in its first cycle has never said anything. Without a network there may be no communication to say something,
            // and the robot stands before every area.
            if read.stamp_ns == 0 && !thread.begins {
                continue;
            }
            let report = read.value;
            let (cycles, missed) = (report.cycles - thread.cycles, report.missed - thread.missed);
            (thread.cycles, thread.missed) = (report.cycles, report.missed);
            thread.seconds_still = match cycles {
                0 => thread.seconds_still.saturating_add(1),
                _ => 0,
            };
            // Of its first second this watch may have seen a part only.
            let partial = u32::from(read.stamp_ns == 0);
            thread.load = if thread.seconds_still >= thread.seconds_to_hang(&report) + partial {
                Load::Hung
            } else {
                thread.load_after(cycles, missed)
            };
        }
        let loads = self.threads.iter().map(|thread| thread.load).enumerate();
        let worst = loads.max_by_key(|(_, load)| *load as u8)?;
        let before = std::mem::replace(&mut self.worst, worst);
        let late = if worst.1 == Load::Fine { before } else { worst };
        let name = &self.threads.get(late.0)?.name;
        (worst.1 != before.1).then(|| (name.clone(), worst.1))
    }

    /// Whether a thread has not run for a second, as last judged.
    #[must_use]
    pub fn hangs(&self) -> bool {
        self.threads.iter().any(|thread| thread.load == Load::Hung)
    }

    /// Judges anew from here on. A thread that hung when it was judged last, and has not run since, goes on hanging.
    pub fn forget(&mut self) {
        for thread in &mut self.threads {
            let hangs = thread.load == Load::Hung && thread.stands_still();
            thread.seconds_over = 0;
            thread.load = if hangs { Load::Hung } else { Load::Fine };
        }
        let hung = { self.threads.iter() }.position(|thread| thread.load == Load::Hung);
        self.worst = hung.map_or((0, Load::Fine), |thread| (thread, Load::Hung));
    }
}

impl Thread {
    fn new(name: String, report: Reader<ThreadReport>, real_time: bool, patience_s: u32) -> Self {
        Self {
            name,
            report,
            begins: true,
            real_time,
            patience_s,
            cycles: 0,
            missed: 0,
            seconds_still: 0,
            seconds_over: 0,
            load: Load::Fine,
        }
    }

    /// Whether it has not run since it was judged last.
    fn stands_still(&mut self) -> bool {
        self.report.read().value.cycles == self.cycles
    }

    fn seconds_to_hang(&self, report: &ThreadReport) -> u32 {
        if report.running != 0 {
            HUNG_SECONDS
        } else {
            self.patience_s
        }
    }

    fn load_after(&mut self, cycles: u64, missed: u64) -> Load {
        let share = if missed < LEAST_MISSED || !self.real_time {
            0.0
        } else {
            missed as f64 / (cycles + missed) as f64
        };
        self.seconds_over = if share > OVERLOADED_SHARE {
            self.seconds_over + 1
        } else {
            0
        };
        if self.seconds_over >= OVERLOADED_SECONDS {
            Load::Overloaded
        } else if share > DEGRADED_SHARE {
            Load::Degraded
        } else {
            Load::Fine
        }
    }
}

/// For how many seconds a thread may have no cycle before its activities run: that of the drive brings its bus up, that of the lidar
/// connects it.
pub(crate) fn patience_s(robot: &RobotConfig, thread: &ThreadConfig) -> u32 {
    let most = |kind: &ActivityKind| match kind {
        ActivityKind::Drive => robot.ethercat.bring_up_s.ceil() as u32,
        ActivityKind::Lidar => Options::default().connect_timeout.as_secs() as u32,
        ActivityKind::Communication => OPENING_SECONDS,
        _ => 0,
    };
    // A second is judged as a whole.
    HUNG_SECONDS + thread.activities.iter().map(most).max().unwrap_or(0)
}

#[cfg(test)]
mod tests {
    use bytemuck::Zeroable;

    use super::*;
    use crate::process::bench::Bench;

    /// What is said after each second of these cycles and missed periods.
    fn judged(running: bool, real_time: bool, seconds: &[[u64; 2]]) -> Vec<Option<Load>> {
        let (bench, mut writer) = Bench::new();
        let mut watch = OverrunWatch {
            threads: vec![Thread::new("motion".to_owned(), bench.report, real_time, 3)],
            judged_ns: 0,
            worst: (0, Load::Fine),
        };
        let mut report = ThreadReport::zeroed();
        report.running = u64::from(running);
        let mut now_ns = 0;
        let mut judge = |[cycles, missed]: &[u64; 2]| {
            now_ns += SECOND_NS;
            report.cycles += cycles;
            report.missed += missed;
            writer.write(now_ns, &report);
            let judged = watch.judge(now_ns);
            assert_eq!(watch.judge(now_ns + 1), None, "once a second");
            judged.map(|(_, load)| load)
        };
        seconds.iter().map(&mut judge).collect()
    }

    #[test]
    fn repeated_overruns_degrade_then_overload_and_are_over_when_they_are() {
        let seconds = [
            ([200, 0], None),
            ([198, 2], None),
            ([170, 30], Some(Load::Degraded)),
            ([100, 100], None),
            ([100, 100], None),
            // One that was very late.
            ([20, 180], Some(Load::Overloaded)),
            ([200, 0], Some(Load::Fine)),
        ];
        let (happens, expected): (Vec<_>, Vec<_>) = seconds.into_iter().unzip();
        assert_eq!(judged(true, true, &happens), expected);
        assert_eq!(judged(true, false, &happens), [None; 7], "no deadlines");
    }

    #[test]
    fn a_thread_that_does_not_run_is_hung_unless_it_has_nothing_to_run() {
        let happens = [[200, 0], [0, 0], [0, 0], [1, 399]];
        let found = [None, Some(Load::Hung), None, Some(Load::Degraded)];
        assert_eq!(judged(true, true, &happens), found);
        // A bring-up takes its time, and no more.
        assert_eq!(judged(false, true, &happens)[..3], [None; 3]);
        let happens_not = [[200, 0], [0, 0], [0, 0], [0, 0], [0, 0], [9, 0]];
        let found = [None, None, None, Some(Load::Hung), None, Some(Load::Fine)];
        assert_eq!(judged(false, true, &happens_not), found);
        assert_eq!(judged(true, false, &happens)[1], Some(Load::Hung));
    }

    #[test]
    fn a_thread_that_hangs_is_not_forgotten_until_it_runs() {
        let (bench, mut writer) = Bench::new();
        let mut watch = OverrunWatch {
            threads: vec![Thread::new("motion".to_owned(), bench.report, true, 3)],
            judged_ns: 0,
            worst: (0, Load::Fine),
        };
        let mut report = ThreadReport::zeroed();
        (report.cycles, report.running) = (200, 1);
        writer.write(1, &report);
        assert_eq!(watch.judge(SECOND_NS), None);
        let hung = watch.judge(2 * SECOND_NS);
        assert_eq!(hung, Some(("motion".to_owned(), Load::Hung)));
        watch.forget();
        assert!(watch.hangs());
        assert_eq!(watch.judge(3 * SECOND_NS), None, "that is no news");
        report.cycles += 1;
        writer.write(2, &report);
        watch.forget();
        assert!(!watch.hangs());
    }

    #[test]
    fn a_thread_that_hangs_in_its_first_cycle_is_found_and_one_without_activities_is_not() {
        for (begins, expected) in [(true, Some(Load::Hung)), (false, None)] {
            let (bench, _writer) = Bench::new();
            let name = "motion".to_owned();
            let mut watch = OverrunWatch {
                threads: vec![Thread {
                    begins,
                    ..Thread::new(name, bench.report, true, 1)
                }],
                judged_ns: 0,
                worst: (0, Load::Fine),
            };
            assert_eq!(watch.judge(SECOND_NS), None);
            let judged = watch.judge(2 * SECOND_NS);
            assert_eq!(judged.map(|(_, load)| load), expected);
        }
    }

    #[test]
    fn the_thread_that_was_late_keeps_its_time_again() {
        let names = ["fieldbus", "motion", "navigation"];
        let (mut writers, mut threads) = (Vec::new(), Vec::new());
        for name in names {
            let (bench, writer) = Bench::new();
            writers.push(writer);
            threads.push(Thread::new(name.to_owned(), bench.report, true, 3));
        }
        let mut watch = OverrunWatch {
            threads,
            judged_ns: 0,
            worst: (0, Load::Fine),
        };
        let mut report = ThreadReport::zeroed();
        report.running = 1;
        let mut judge = |second: u64, late: &str| {
            report.cycles += 100;
            for (writer, name) in writers.iter_mut().zip(names) {
                let mut report = report;
                report.missed = 50 * u64::from(name == late);
                writer.write(second * SECOND_NS, &report);
            }
            watch.judge(second * SECOND_NS)
        };
        assert_eq!(judge(1, ""), None);
        assert_eq!(
            judge(2, "fieldbus"),
            Some(("fieldbus".to_owned(), Load::Degraded))
        );
        assert_eq!(
            judge(3, "fieldbus"),
            Some(("fieldbus".to_owned(), Load::Fine))
        );
    }
}
