//! `summary.json`: what a run leaves for programs to read.

use serde::{Deserialize, Serialize};
use serde_json::Value as Json;

use crate::figures::{Figures, or_infinite};
use crate::machine::Machine;
use crate::percentile::Ranked;
use crate::stalls::{LongStall, Stalls};
use crate::violation::ViolationKind;

/// Outcome of a run that reached all goals.
pub const DONE: &str = "done";

/// The whole summary.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct Summary {
    /// Name of the scenario.
    pub scenario: String,
    /// `done`, `interrupted`, or what is missing.
    pub outcome: String,
    /// The robots' fault that nobody was to clear, where one ended the run.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub stranded_by: Option<String>,
    /// Since when the robot had it, seconds since the start.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub stranded_since_s: Option<f64>,
    /// Decides wheel errors, start offsets and noise.
    pub seed: u64,
    /// From the first robot's start to the end.
    pub duration_s: f64,
    /// What it ran on, so that figures can be judged.
    pub machine: Machine,
    /// How often and how long the machine stalled; none on the simulated clock.
    pub stalls: Option<Stalls>,
    /// When it stalled for so long that the run may be spoiled; a stall of several cores counts for each.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub long_stalls: Vec<LongStall>,
    /// The run before this one, if a stall of the machine spoiled it: this one is its repetition.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub spoiled: Option<Spoiled>,
    /// One entry for each robot, in the order of their identities.
    pub robots: Vec<RobotSummary>,
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

/// A run that failed while the machine stalled, and that was made once more.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Spoiled {
    /// Why it failed, in a line.
    pub reason: String,
    /// How often and how long the machine stalled.
    pub stalls: Stalls,
}

/// What happened to one robot.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct RobotSummary {
    /// Its identity.
    pub id: String,
    /// Its role on the site.
    pub role: String,
    /// Rounds or laps by the world's truth.
    pub laps: u32,
    /// Rounds or laps that it was to drive.
    pub wanted: u32,
    /// When it had reached its goal, seconds since the start.
    pub done_s: Option<f64>,
    /// Way driven.
    pub distance_m: f64,
    /// Collisions.
    pub collisions: u64,
    /// Smallest distance of its footprint to anything.
    #[serde(deserialize_with = "or_infinite")]
    pub min_clearance_m: f64,
    /// Largest distance of `base_link` from the lane's centre in areas that are driven forward on a lane.
    pub max_lateral_error_m: f64,
    /// Fastest true speed.
    pub max_speed_m_s: f64,
    /// Largest wheel setpoint that its drive received.
    pub max_setpoint_rad_s: f64,
    /// Threads, with times in µs, as the robot measured them.
    pub threads: Json,
    /// Counters of the bus.
    pub ethercat: EthercatSummary,
    /// Counters of the lidar.
    pub lidar: LidarSummary,
    /// Resident memory of the robot's process; none on the simulated clock, where it is not one.
    pub rss_mib: Option<f64>,
    /// Share of one core that the robot's process used.
    pub cpu_percent: Option<f64>,
    /// Faults that it raised, and how often.
    pub faults: Vec<(String, u64)>,
    /// How often an operator reset it: after a stall of the machine, or after an injected fault.
    pub resets: u32,
    /// How often an operator drove it out by hand, where it found no way.
    pub driven_out: u32,
    /// How often an operator restarted it, where the mediator refused it after a clone.
    pub restarted: u32,
    /// How often the rig withheld leave for an area until the robot had waited.
    pub withheld: u64,
    /// What the judge found out, where the scenario looks at what robots believe.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub figures: Option<Figures>,
}

/// Counters of the bus.
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize)]
pub struct EthercatSummary {
    /// Exchanges.
    pub cycles: u64,
    /// Frames without an answer in time.
    pub lost_frames: u64,
    /// Answers with a wrong working counter.
    pub wkc_errors: u64,
}

/// Counters of the lidar.
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize)]
pub struct LidarSummary {
    /// Good scans.
    pub scans: u64,
    /// Scans dropped as broken.
    pub dropped: u64,
}

/// Something that must not happen.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Violation {
    /// What happened.
    pub kind: ViolationKind,
    /// Robot, a `clone of` one, `mediator` or `network`.
    pub robot: String,
    /// Seconds since the start.
    pub at_s: f64,
    /// What was found and what was expected.
    pub detail: String,
}

/// The mediator's processes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct MediatorSummary {
    /// How often it was started.
    pub starts: u32,
    /// Messages, reports and questions that found a full queue; none through the real programs, whose log tells.
    pub dropped: Option<u64>,
    /// Largest resident memory; none on the simulated clock.
    pub rss_mib: Option<f64>,
    /// Share of one core that the last process used.
    pub cpu_percent: Option<f64>,
}

/// One area.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct AreaSummary {
    /// Its id.
    pub id: String,
    /// How many robots it holds.
    pub capacity: u32,
    /// Who had it, in the order of grants.
    pub owners: Vec<Holding>,
    /// Longest time from a request to its grant.
    pub longest_wait_s: f64,
}

/// A robot had an area: one run of protocol 1. Times are seconds since the start, when messages were heard.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Holding {
    /// Area.
    #[serde(skip)]
    pub area: String,
    /// Robot.
    pub robot: String,
    /// Of the grant.
    pub fence: u64,
    /// When it asked; none when the grant was heard without a request.
    pub requested_s: Option<f64>,
    /// When it was granted.
    pub granted_s: f64,
    /// When it entered; none: it did not.
    pub entered_s: Option<f64>,
    /// When it left, or gave the grant back; none: it had the area until the end.
    pub released_s: Option<f64>,
    /// It gave the grant back without having entered.
    #[serde(skip)]
    pub returned: bool,
}

/// A net was run. Times are seconds since the start.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct CoordinationSummary {
    /// Its number.
    pub number: u64,
    /// Its id in the site file.
    pub id: String,
    /// The net.
    pub net: String,
    /// In which situation it began; empty: its robots were told to get out of the way.
    pub situation: String,
    /// Who took part.
    pub robots: Vec<PartSummary>,
    /// When it began.
    pub from_s: f64,
    /// How long it took; none: it was not over.
    pub duration_s: Option<f64>,
    /// What fired, in order.
    pub firings: Vec<FiringSummary>,
    /// Places that were marked when it was seen last.
    #[serde(skip)]
    pub marking: Vec<String>,
}

impl CoordinationSummary {
    /// When it was over; none: it ran until the end.
    #[must_use]
    pub fn to_s(&self) -> Option<f64> {
        self.duration_s.map(|duration_s| self.from_s + duration_s)
    }
}

/// A role of a net and its robot.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct PartSummary {
    /// Role of the net.
    pub role: String,
    /// Robot.
    pub robot: String,
}

/// A transition fired.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct FiringSummary {
    /// The transition.
    pub transition: String,
    /// When, seconds since the start.
    pub at_s: f64,
}

/// A distribution of latencies.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Latency {
    /// How many were measured.
    pub count: usize,
    /// Median, as all percentiles by nearest rank; none without a measurement, as the others.
    pub p50_ms: Option<f64>,
    /// 99th percentile.
    pub p99_ms: Option<f64>,
    /// Largest.
    pub max_ms: Option<f64>,
}

/// What had to be true while something else was.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct DuringSummary {
    /// In a sentence.
    pub rule: String,
    /// How long it was checked.
    pub checked_s: f64,
    /// How long of that it was not true.
    pub broken_s: f64,
}

impl Summary {
    /// All goals were reached.
    #[must_use]
    pub fn is_done(&self) -> bool {
        self.outcome == DONE
    }

    /// All goals were reached, and nothing happened that must not.
    #[must_use]
    pub fn passed(&self) -> bool {
        self.is_done() && self.violations.is_empty()
    }

    /// How many violations there were, to be said after the outcome; empty without any.
    #[must_use]
    pub fn with_violations(&self) -> String {
        match self.violations.len() {
            0 => String::new(),
            1 => ", 1 violation".to_owned(),
            more => format!(", {more} violations"),
        }
    }

    /// Why the run failed, in a line.
    #[must_use]
    pub fn reason(&self) -> String {
        let mut reasons: Vec<String> = { self.violations.iter() }
            .take(3)
            .map(|own| format!("{} at {:.1} s: {}", own.kind, own.at_s, own.detail))
            .collect();
        if !self.is_done() {
            reasons.push(self.outcome.clone());
        }
        reasons.join("; ")
    }
}

impl Latency {
    /// Of these measurements, in any order.
    #[must_use]
    pub fn of(measured_ms: &[f64]) -> Self {
        let ranked = Ranked::of(measured_ms.iter().copied());
        let at = |share: f64| ranked.at(share).map(|ms| (ms * 1e3).round() / 1e3);
        Self {
            count: ranked.count(),
            p50_ms: at(0.5),
            p99_ms: at(0.99),
            max_ms: at(1.0),
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
