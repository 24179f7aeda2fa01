//! Violations, each reported once for as long as it lasts.

use std::collections::BTreeMap;

use crate::summary::Violation;
use crate::violation::ViolationKind;

/// A violation of one kind by one robot is reported again when it has been absent for this long.
const STRETCH_NS: u64 = 1_000_000_000;
/// Most violations reported of one robot: longer lists say nothing more.
const MOST: usize = 64;

/// The violations of a run.
#[derive(Debug)]
pub(super) struct Violations {
    start_ns: u64,
    /// When each kind was last found of each robot.
    last_ns: BTreeMap<(String, ViolationKind), u64>,
    counts: BTreeMap<String, usize>,
    all: Vec<Violation>,
}

impl Violations {
    /// None yet in a run that began at `start_ns`.
    pub(super) fn new(start_ns: u64) -> Self {
        Self {
            start_ns,
            last_ns: BTreeMap::new(),
            counts: BTreeMap::new(),
            all: Vec::new(),
        }
    }

    /// Records a violation, unless it is one that still lasts.
    pub(super) fn report(&mut self, kind: ViolationKind, robot: &str, at_ns: u64, detail: String) {
        let key = (robot.to_owned(), kind);
        let before = self.last_ns.insert(key, at_ns);
        let count = self.counts.entry(robot.to_owned()).or_default();
        // What is found at the end of a run is not found in the order of its times.
        let is_another = |before_ns: u64| at_ns.abs_diff(before_ns) > STRETCH_NS;
        if before.is_none_or(is_another) && *count < MOST {
            *count += 1;
            self.all.push(Violation {
                kind,
                robot: robot.to_owned(),
                at_s: at_ns.saturating_sub(self.start_ns) as f64 / 1e9,
                detail,
            });
        }
    }

    pub(super) fn all(&self) -> &[Violation] {
        &self.all
    }
}
