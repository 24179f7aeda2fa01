//! Watches the real-time threads' overruns, second by second.

use coordination::symbols::Reader;
use description::threads::ThreadConfig;

use crate::composition::plan::wanted_scheduling;
use crate::realtime::clock::SECOND_NS;
use crate::symbols::values::ThreadReport;

/// Share of cycles in a second from which the robot slows down.
const DEGRADED_SHARE: f64 = 0.10;
/// Share of cycles in a second that counts towards a stop.
const OVERLOADED_SHARE: f64 = 0.30;
/// Seconds in a row over that share that stop the robot.
const OVERLOADED_SECONDS: u32 = 3;
/// Fewer overruns in a second than this are never judged: a thread with few cycles has coarse shares.
const LEAST_OVERRUNS: u64 = 3;

/// How well a thread keeps its deadlines.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Load {
    /// It keeps them.
    Fine,
    /// It misses so often that the robot slows down.
    Degraded,
    /// It misses so often that the robot stops.
    Overloaded,
}

#[derive(Debug)]
struct Thread {
    name: String,
    report: Reader<ThreadReport>,
    cycles: u64,
    overruns: u64,
    seconds_over: u32,
    load: Load,
}

/// Watches the reports of all real-time threads.
#[derive(Debug)]
pub struct OverrunWatch {
    threads: Vec<Thread>,
    judged_ns: u64,
    worst: Load,
}

impl OverrunWatch {
    /// Watches those of these threads that ask for a real-time priority, by their reports.
    #[must_use]
    pub fn of(threads: &[ThreadConfig], reports: Vec<Reader<ThreadReport>>) -> Self {
        let real_time = { threads.iter().zip(reports) }
            .filter(|(thread, _)| wanted_scheduling(thread).fifo_priority.is_some());
        Self::new(
            real_time
                .map(|(thread, report)| (thread.name.clone(), report))
                .collect(),
        )
    }

    /// Watches these threads.
    #[must_use]
    pub fn new(threads: Vec<(String, Reader<ThreadReport>)>) -> Self {
        let threads = threads
            .into_iter()
            .map(|(name, report)| Thread {
                name,
                report,
                cycles: 0,
                overruns: 0,
                seconds_over: 0,
                load: Load::Fine,
            })
            .collect();
        Self {
            threads,
            judged_ns: 0,
            worst: Load::Fine,
        }
    }

    /// Once a second: the thread with the worst load, when that load has changed.
    pub fn judge(&mut self, now_ns: u64) -> Option<(String, Load)> {
        if now_ns < self.judged_ns + SECOND_NS {
            return None;
        }
        self.judged_ns = now_ns;
        for thread in &mut self.threads {
            let report = thread.report.read().value;
            let (cycles, overruns) = (
                report.cycles - thread.cycles,
                report.overruns - thread.overruns,
            );
            (thread.cycles, thread.overruns) = (report.cycles, report.overruns);
            thread.load = thread.load_after(cycles, overruns);
        }
        let worst = self.threads.iter().max_by_key(|thread| thread.load as u8)?;
        let news = std::mem::replace(&mut self.worst, worst.load) != worst.load;
        news.then(|| (worst.name.clone(), worst.load))
    }

    /// Judges anew from here on.
    pub fn forget(&mut self) {
        self.worst = Load::Fine;
        for thread in &mut self.threads {
            (thread.seconds_over, thread.load) = (0, Load::Fine);
        }
    }
}

impl Thread {
    fn load_after(&mut self, cycles: u64, overruns: u64) -> Load {
        let share = if overruns < LEAST_OVERRUNS {
            0.0
        } else {
            overruns as f64 / cycles.max(1) as f64
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

#[cfg(test)]
mod tests {
    use bytemuck::Zeroable;

    use super::*;
    use crate::process::bench::Bench;

    #[test]
    fn repeated_overruns_degrade_then_overload_and_a_reset_forgives() {
        let (bench, mut writer) = Bench::new();
        let mut watch = OverrunWatch::new(vec![("motion".to_owned(), bench.report)]);
        let mut report = ThreadReport::zeroed();
        // Overruns in each second of 200 cycles, and what is to be said of it.
        let seconds = [
            (0, None),
            (2, None),
            (30, Some(Load::Degraded)),
            (100, None),
            (100, None),
            (100, Some(Load::Overloaded)),
            (0, Some(Load::Fine)),
        ];
        for (second, (overruns, expected)) in seconds.into_iter().enumerate() {
            report.cycles += 200;
            report.overruns += overruns;
            writer.write(1, &report);
            let judged = watch
                .judge((second as u64 + 1) * SECOND_NS)
                .map(|(_, load)| load);
            assert_eq!(judged, expected, "second {second}");
        }
        assert_eq!(watch.judge(7 * SECOND_NS + 1), None, "once a second");
    }
}
