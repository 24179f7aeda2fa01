//! What the threads of a robot report of themselves.

use std::fmt::{Debug, Formatter, Result as Written};

use coordination::symbols::Inspector;
use onboard::process::inspect;
use onboard::process::runtime::Runtime;
use onboard::realtime::histogram::Histogram;
use onboard::symbols::values::ThreadReport;
use serde_json::Value as Json;

use crate::programs::late::note_late;

/// As the robot file has them.
const THREADS: usize = 5;
/// The share of its periods that a real-time thread may miss, whatever others do: half of what slows a robot down.
const MISSED_SHARE: f64 = 0.05;
/// How late it may be in ninety-nine of a hundred wake-ups, of a robot that has none beside it: ten times what TIMING.md has under load.
pub const LATE_ALONE_US: f64 = 500.0;
/// And beside robots of other tests, whose threads have the same priority and come first as often: two cycles of the bus.
pub const LATE_BESIDE_OTHERS_US: f64 = 2_000.0;

/// One thread, since it was started.
#[derive(Clone, Debug)]
pub struct ThreadFigures {
    pub name: String,
    /// It was granted a real-time priority.
    pub is_real_time: bool,
    pub cycles: u64,
    /// Periods without a cycle.
    pub missed: u64,
    /// Since it drives the robot.
    pub page_faults: u64,
    /// How late its wake-ups were.
    late: Late,
}

#[derive(Clone)]
struct Late(Histogram);

impl Late {
    /// In ninety-nine of a hundred.
    fn p99_us(&self) -> f64 {
        self.0.quantile_ns(0.99) as f64 * 1e-3
    }
}

impl Debug for Late {
    fn fmt(&self, formatter: &mut Formatter) -> Written {
        write!(formatter, "{} wake-ups, ", self.0.count())?;
        write!(formatter, "99 of 100 by {:.0} µs at most", self.p99_us())
    }
}

impl ThreadFigures {
    /// Those of all threads of a robot, in an order that does not change.
    pub fn of(runtime: &Runtime, robot: &str) -> Vec<Self> {
        let seen = inspect::snapshot(runtime, robot);
        let seen = seen.unwrap_or_else(|failure| panic!("{robot}: {failure:?}"));
        let symbols = seen["symbols"].as_array().expect("a list").iter();
        let reports = symbols.filter(|symbol| symbol["datatype"] == "thread_report");
        let inspector = Inspector::open(robot, &runtime.place()).expect("it runs");
        let all: Vec<Self> = { reports.map(|thread| Self::read(thread, &inspector)) }.collect();
        assert_eq!(all.len(), THREADS, "{all:?}");
        if !all.iter().any(|thread| thread.is_real_time) {
            eprintln!(
                "SKIPPED: figures of real-time threads need CAP_SYS_NICE or a higher `ulimit -r`"
            );
        }
        all
    }

    fn read(thread: &Json, inspector: &Inspector) -> Self {
        let value = &thread["value"];
        let name = thread["model"].as_str().expect("a name").to_owned();
        let mut report = { inspector.reader::<ThreadReport>(&name) }.expect("it is listed");
        let number = |what: &str| value[what].as_u64();
        let known = |what: &str| number(what).unwrap_or_else(|| panic!("{what}: {thread}"));
        Self {
            name,
            is_real_time: value["granted"]["policy"] == "fifo",
            cycles: known("cycles"),
            missed: known("missed"),
            page_faults: known("page_faults"),
            late: Late(report.read().value.wakeup),
        }
    }

    /// What was added since.
    pub fn since(&self, before: &Self) -> Self {
        assert_eq!(self.name, before.name);
        Self {
            cycles: self.cycles - before.cycles,
            missed: self.missed - before.missed,
            page_faults: self.page_faults - before.page_faults,
            late: Late(self.late.0.since(&before.late.0)),
            ..self.clone()
        }
    }
}

/// All real-time threads have kept their time between the one and the other.
pub fn all_keep_their_time(before: &[ThreadFigures], after: &[ThreadFigures]) {
    for thread in added(before, after) {
        let share = thread.missed as f64 / thread.cycles.max(1) as f64;
        let keeps_its_time = !thread.is_real_time || share < MISSED_SHARE;
        if !keeps_its_time {
            note_late();
        }
        assert!(keeps_its_time, "{thread:?}");
    }
}

/// All real-time threads have been punctual between the one and the other.
pub fn all_are_punctual(before: &[ThreadFigures], after: &[ThreadFigures], most_us: f64) {
    for thread in added(before, after) {
        let is_punctual = !thread.is_real_time || thread.late.p99_us() < most_us;
        if !is_punctual {
            note_late();
        }
        println!("{}: {:?}", thread.name, thread.late);
        assert!(is_punctual, "{thread:?}");
    }
}

/// What was added to each.
pub fn added(before: &[ThreadFigures], after: &[ThreadFigures]) -> Vec<ThreadFigures> {
    let pairs = after.iter().zip(before);
    pairs.map(|(after, before)| after.since(before)).collect()
}
