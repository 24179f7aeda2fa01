//! A record as figures and tables need it: robots by identity, colours, and the range of time.

use crate::record::{Record, RobotRecord};
use crate::summary::CoordinationSummary;

use super::style::COLOURS;

/// The record, and what is derived of it once.
#[derive(Debug)]
pub(super) struct View<'a> {
    pub(super) record: &'a Record,
    /// When it ended; everything is shown from 0 to there.
    pub(super) end_s: f64,
}

impl<'a> View<'a> {
    pub(super) fn new(record: &'a Record) -> Self {
        const LEAST_S: f64 = 1.0;
        let paths = record.robots.iter().filter_map(|robot| robot.path.last());
        let releases = record.holdings.iter().flat_map(|holding| {
            [
                Some(holding.granted_s),
                holding.entered_s,
                holding.released_s,
            ]
        });
        let ends = { record.summary.coordinations.iter() }.map(CoordinationSummary::to_s);
        let end_s = paths
            .map(|point| point.at_s)
            .chain(releases.flatten())
            .chain(ends.flatten())
            .chain([record.summary.duration_s])
            .filter(|at_s| at_s.is_finite())
            .fold(LEAST_S, f64::max);
        Self { record, end_s }
    }

    /// Class that gives a robot's colour; those that are not in the record share one.
    pub(super) fn class(&self, robot: &str) -> String {
        let index = self.record.robots.iter().position(|own| own.id == robot);
        index.map_or_else(
            || "neutral".to_owned(),
            |index| format!("r{}", index % COLOURS),
        )
    }

    /// The robot with this identity.
    pub(super) fn robot(&self, id: &str) -> Option<&'a RobotRecord> {
        self.record.robots.iter().find(|robot| robot.id == id)
    }

    /// The part of a span that is shown; none if it has no length or is not in order.
    pub(super) fn shown(&self, from_s: f64, to_s: Option<f64>) -> Option<(f64, f64)> {
        let (from_s, to_s) = (from_s.max(0.0), to_s.unwrap_or(self.end_s).min(self.end_s));
        (from_s.is_finite() && to_s >= from_s).then_some((from_s, to_s))
    }
}

/// The robots of a coordination with their roles, in words.
pub(super) fn cast(run: &CoordinationSummary) -> String {
    let parts: Vec<String> = run
        .robots
        .iter()
        .map(|part| format!("{}: {}", part.role, part.robot))
        .collect();
    parts.join(", ")
}
