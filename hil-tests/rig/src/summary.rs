//! `summary.json` of a scenario with a fleet.

use serde::Serialize;

use crate::one_robot::summary::{Machine, RobotSummary, Violation};

/// The whole summary.
#[derive(Clone, Debug, Serialize)]
pub struct FleetSummary {
    /// Name of the scenario.
    pub scenario: String,
    /// `done`, `interrupted`, or what is missing.
    pub outcome: String,
    /// Decides wheel errors, start offsets and noise.
    pub seed: u64,
    /// From the first robot's start to the end.
    pub duration_s: f64,
    /// What it ran on, so that figures can be judged.
    pub machine: Machine,
    /// One entry for each robot, in the order of their identities.
    pub robots: Vec<MemberSummary>,
    /// The mediator's processes; none without one.
    pub mediator: Option<MediatorSummary>,
    /// Areas, in the order of the site file.
    pub areas: Vec<AreaSummary>,
    /// Coordinations, in the order of their numbers.
    pub coordinations: Vec<CoordinationSummary>,
    /// From requests that could be granted at once to their grants, as the listener heard both.
    pub grants: Latency,
    /// From a robot's flag to the mediator's next command through the net, as the listener heard both.
    pub commands: Latency,
    /// What had to be true while something else was.
    pub during: Vec<DuringSummary>,
    /// What must not happen and did, from the world's truth, the devices' own records and the independent listener.
    pub violations: Vec<Violation>,
}

/// One robot of a fleet.
#[derive(Clone, Debug, Default, Serialize)]
pub struct MemberSummary {
    /// As for a robot alone; `laps` are rounds of its goal by the world's truth.
    #[serde(flatten)]
    pub robot: RobotSummary,
    /// Its role on the site.
    pub role: String,
    /// Rounds that it was to drive.
    pub wanted: u32,
    /// When it had driven them, seconds since the start.
    pub done_s: Option<f64>,
}

/// The mediator's processes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct MediatorSummary {
    /// How often it was started.
    pub starts: u32,
    /// Largest resident memory.
    pub rss_mib: f64,
    /// Share of one core that the last process used.
    pub cpu_percent: f64,
}

/// One area.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct AreaSummary {
    /// Its id.
    pub id: String,
    /// How many robots it holds.
    pub capacity: u32,
    /// Who had it, in the order of grants.
    pub owners: Vec<OwnerSummary>,
    /// Longest time from a request to its grant.
    pub longest_wait_s: f64,
}

/// A robot had an area. Times are seconds since the start.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct OwnerSummary {
    /// Robot.
    pub robot: String,
    /// Of the grant.
    pub fence: u64,
    /// When it asked.
    pub requested_s: Option<f64>,
    /// When it was granted.
    pub granted_s: f64,
    /// When it entered; none: it did not.
    pub entered_s: Option<f64>,
    /// When it gave it back; none: it did not.
    pub released_s: Option<f64>,
}

/// A net was run. Times are seconds since the start.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct CoordinationSummary {
    /// Its number.
    pub number: u64,
    /// Its id in the site file.
    pub id: String,
    /// The net.
    pub net: String,
    /// In which situation it began.
    pub situation: String,
    /// Who took part.
    pub robots: Vec<PartSummary>,
    /// When it began.
    pub from_s: f64,
    /// How long it took; none: it was not over.
    pub duration_s: Option<f64>,
    /// What fired, in order.
    pub firings: Vec<FiringSummary>,
}

/// A role of a net and its robot.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct PartSummary {
    /// Role of the net.
    pub role: String,
    /// Robot.
    pub robot: String,
}

/// A transition fired.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct FiringSummary {
    /// The transition.
    pub transition: String,
    /// When, seconds since the start.
    pub at_s: f64,
}

/// A distribution of latencies.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Latency {
    /// How many were measured.
    pub count: usize,
    /// Median; none without a measurement, as the others.
    pub p50_ms: Option<f64>,
    /// 99th percentile, by nearest rank.
    pub p99_ms: Option<f64>,
    /// Largest.
    pub max_ms: Option<f64>,
}

/// What had to be true while something else was.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct DuringSummary {
    /// In a sentence.
    pub rule: String,
    /// How long it was checked.
    pub checked_s: f64,
    /// How long of that it was not true.
    pub broken_s: f64,
}

impl Latency {
    /// Of these measurements, in any order.
    #[must_use]
    pub fn of(measured_ms: &[f64]) -> Self {
        let mut sorted: Vec<f64> = measured_ms.to_vec();
        sorted.sort_by(f64::total_cmp);
        let rank = |share: f64| {
            let rank = (share * sorted.len() as f64).ceil() as usize;
            sorted
                .get(rank.clamp(1, sorted.len().max(1)) - 1)
                .map(|value| (value * 1e3).round() / 1e3)
        };
        Self {
            count: sorted.len(),
            p50_ms: rank(0.5),
            p99_ms: rank(0.99),
            max_ms: rank(1.0),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn percentiles_are_by_nearest_rank() {
        let measured: Vec<f64> = (1..=200).rev().map(f64::from).collect();
        let latency = Latency::of(&measured);
        assert_eq!(
            (latency.count, latency.p50_ms, latency.p99_ms),
            (200, Some(100.0), Some(198.0))
        );
        assert_eq!(latency.max_ms, Some(200.0));
        assert_eq!(Latency::of(&[3.0]).p50_ms, Some(3.0));
        assert_eq!(Latency::of(&[]), Latency::default());
    }
}
