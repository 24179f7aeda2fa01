//! What the threads of a robot report of themselves.

use onboard::process::inspect;
use onboard::process::runtime::Runtime;
use serde_json::Value as Json;

use crate::programs::late::note_late;

/// As the robot file has them.
const THREADS: usize = 5;
/// The share of its periods that a real-time thread may miss, whatever others do: half of what slows a robot down.
const MISSED_SHARE: f64 = 0.05;
/// How late it may be in ninety-nine of a hundred wake-ups since its start: ten times what TIMING.md has under load.
const LATE_US: f64 = 500.0;

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
    /// How late ninety-nine of a hundred wake-ups were at most, since its start.
    pub late_us: f64,
}

impl ThreadFigures {
    /// Those of all threads of a robot, in an order that does not change.
    pub fn of(runtime: &Runtime, robot: &str) -> Vec<Self> {
        let seen = inspect::snapshot(runtime, robot);
        let seen = seen.unwrap_or_else(|failure| panic!("{robot}: {failure:?}"));
        let symbols = seen["symbols"].as_array().expect("a list").iter();
        let reports = symbols.filter(|symbol| symbol["datatype"] == "thread_report");
        let all: Vec<Self> = reports.map(Self::read).collect();
        assert_eq!(all.len(), THREADS, "{all:?}");
        if !all.iter().any(|thread| thread.is_real_time) {
            eprintln!(
                "SKIPPED: figures of real-time threads need CAP_SYS_NICE or a higher `ulimit -r`"
            );
        }
        all
    }

    fn read(thread: &Json) -> Self {
        let value = &thread["value"];
        let number = |what: &str| value[what].as_u64();
        let known = |what: &str| number(what).unwrap_or_else(|| panic!("{what}: {thread}"));
        Self {
            name: thread["model"].as_str().expect("a name").to_owned(),
            is_real_time: value["granted"]["policy"] == "fifo",
            cycles: known("cycles"),
            missed: known("missed"),
            page_faults: known("page_faults"),
            late_us: value["wakeup"]["p99"].as_f64().expect("a figure"),
        }
    }

    /// What was added since.
    pub fn since(&self, before: &Self) -> Self {
        assert_eq!(self.name, before.name);
        Self {
            cycles: self.cycles - before.cycles,
            missed: self.missed - before.missed,
            page_faults: self.page_faults - before.page_faults,
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

/// The real-time threads of a robot that has none beside it have been punctual: those of others, of the same priority, come first as often.
pub fn all_are_punctual(threads: &[ThreadFigures]) {
    for thread in threads {
        let is_punctual = !thread.is_real_time || thread.late_us < LATE_US;
        if !is_punctual {
            note_late();
        }
        assert!(is_punctual, "{thread:?}");
    }
}

/// What was added to each.
pub fn added(before: &[ThreadFigures], after: &[ThreadFigures]) -> Vec<ThreadFigures> {
    let pairs = after.iter().zip(before);
    pairs.map(|(after, before)| after.since(before)).collect()
}
