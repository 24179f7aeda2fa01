//! `rig agreement`: whether stepped runs and runs of the real programs come to the same, seed by seed.
//!
//! Each seed that a campaign of the real programs has left is run again on the simulated clock. The order of grants of each
//! area, and what fired in each coordination, must be the same; durations and lateral errors may differ by what real
//! threads, a real network and a real kernel make of the times of messages and cycles. Where the machine stalled in the real run
//! they are not compared, which is said.

use std::cmp::Ordering;
use std::fs;
use std::path::Path;

use onboard::cli::Failure;
use serde::Serialize;

use super::stepped;
use crate::machine::Machine;
use crate::output::write_json;
use crate::scenario::Scenario;
use crate::stalls::Stalls;
use crate::stepped::Plans;
use crate::summary::{
    AreaSummary, CoordinationSummary, FiringSummary, Holding, RobotSummary, Summary,
};

/// Durations, and the times at which robots reach their goals, differ by at most this
const DURATION_S: f64 = 2.0;
/// and this share of the real one.
const DURATION_SHARE: f64 = 0.02;
/// Largest lateral errors differ by at most this.
const LATERAL_M: f64 = 0.03;
/// What fires within this time fires at once.
const AT_ONCE_S: f64 = 0.1;

/// A seed, both ways.
#[derive(Debug, Serialize)]
struct Pair {
    seed: u64,
    /// Duration of the real run and of the stepped one.
    duration_s: [f64; 2],
    /// By robot: its largest lateral error, in this order.
    lateral_error_m: Vec<(String, [f64; 2])>,
    /// How the machine stalled in the real run, where it did so for too long for times and lateral errors to be compared.
    stalled: Option<Stalls>,
    /// Grants and firings that were compared.
    compared: usize,
    /// Where they do not agree.
    differences: Vec<String>,
}

/// `agreement.json`.
#[derive(Debug, Serialize)]
struct Report<'a> {
    scenario: &'a str,
    machine: Machine,
    agreeing: usize,
    /// Seeds whose times and lateral errors were compared as well.
    timed: usize,
    pairs: &'a [Pair],
}

/// Steps every seed that has a folder with a summary in `real`, named by it, and compares; leaves `agreement.json` there.
///
/// # Errors
/// [`Failure::Refused`] when there is no such folder or a run cannot be built, [`Failure::Failed`] when they do not agree.
pub fn agreement(scenario: &Scenario, plans: &Plans, real: &Path) -> Result<(), Failure> {
    let summaries = summaries(scenario, real)?;
    onboard::say!("  seed   real s  stepped s  lateral off m  compared  differences");
    let mut pairs = Vec::new();
    for summary in &summaries {
        let stepped = stepped::summary(scenario, plans, summary.seed, true)?;
        let pair = compare(summary, &stepped);
        pair.print();
        pairs.push(pair);
    }
    let agreeing = pairs.iter().filter(|pair| pair.differences.is_empty());
    let agreeing = agreeing.count();
    let timed = pairs.iter().filter(|pair| pair.stalled.is_none()).count();
    let report = Report {
        scenario: &scenario.name,
        machine: Machine::here(),
        agreeing,
        timed,
        pairs: &pairs,
    };
    let file = write_json(real, "agreement.json", &report)?;
    onboard::say!(
        "{agreeing} of {} seeds agree; times and lateral errors were compared in {timed}{}",
        pairs.len(),
        if timed == 0 {
            ": make real runs while the machine is quiet"
        } else {
            ""
        }
    );
    onboard::say!("wrote {}", file.display());
    if agreeing == pairs.len() {
        return Ok(());
    }
    Err(Failure::failed(format_args!(
        "{} of {} seeds do not agree",
        pairs.len() - agreeing,
        pairs.len()
    )))
}

/// What real runs have left, in the order of their seeds.
fn summaries(scenario: &Scenario, real: &Path) -> Result<Vec<Summary>, Failure> {
    let refused = |why: String| Failure::refused(format_args!("{}: {why}", real.display()));
    let entries = fs::read_dir(real).map_err(|error| refused(error.to_string()))?;
    let mut summaries = Vec::new();
    // A campaign names the folders of its runs by their seeds; what else is there, such as stepped runs, is not one of them.
    let is_run = |entry: &fs::DirEntry| {
        let name = entry.file_name();
        name.to_str()
            .is_some_and(|name| name.parse::<u64>().is_ok())
    };
    for entry in entries.flatten().filter(is_run) {
        let Ok(text) = fs::read_to_string(entry.path().join("summary.json")) else {
            continue;
        };
        let summary: Summary = serde_json::from_str(&text)
            .map_err(|error| refused(format!("{}: {error}", entry.path().display())))?;
        if summary.scenario != scenario.name {
            return Err(refused(format!(
                "found a run of `{}`, expected `{}`",
                summary.scenario, scenario.name
            )));
        }
        summaries.push(summary);
    }
    summaries.sort_by_key(|summary| summary.seed);
    if summaries.is_empty() {
        return Err(refused(format!(
            "no run with a summary: `rig campaign {} --runs 10` makes them",
            scenario.name
        )));
    }
    Ok(summaries)
}

fn compare(real: &Summary, stepped: &Summary) -> Pair {
    let mut pair = Pair {
        seed: real.seed,
        duration_s: [real.duration_s, stepped.duration_s],
        lateral_error_m: Vec::new(),
        stalled: None,
        compared: 0,
        differences: Vec::new(),
    };
    pair.same(
        "outcome",
        [real, stepped].map(|run| vec![run.outcome.clone()]),
    );
    let goals = |run: &Summary| run.robots.iter().map(goal).collect();
    pair.same("goals", [real, stepped].map(goals));
    for (one, other) in real.areas.iter().zip(&stepped.areas) {
        let what = format!("grants of area {}", one.id);
        pair.same(&what, [one, other].map(grants));
    }
    let nets = |run: &Summary| run.coordinations.iter().map(net).collect();
    pair.same("coordinations", [real, stepped].map(nets));
    for (one, other) in real.coordinations.iter().zip(&stepped.coordinations) {
        let what = format!("firings of {} {}", one.id, one.number);
        pair.same(&what, [one, other].map(firings));
    }
    // What was late then is no difference between the programs and the simulation: only orders are compared.
    if let Some(stalls) = real.stalls.filter(Stalls::spoil) {
        pair.stalled = Some(stalls);
        return pair;
    }
    pair.near(
        "duration in seconds",
        pair.duration_s,
        within_s(real.duration_s),
    );
    for (one, other) in real.robots.iter().zip(&stepped.robots) {
        let done_s = [one, other].map(|robot| robot.done_s.unwrap_or(f64::NAN));
        let what = format!("goal of {} in seconds", one.id);
        pair.near(&what, done_s, within_s(done_s[0]));
        let errors_m = [one, other].map(|robot| robot.max_lateral_error_m);
        let what = format!("lateral error of {} in metres", one.id);
        pair.near(&what, errors_m, LATERAL_M);
        pair.lateral_error_m.push((one.id.clone(), errors_m));
    }
    pair
}

impl Pair {
    /// Both ways it must be the same.
    fn same(&mut self, what: &str, both: [Vec<String>; 2]) {
        let [real, stepped] = both;
        self.compared += real.len();
        if real != stepped {
            let difference = format!("{what}: real {real:?}, stepped {stepped:?}");
            self.differences.push(difference);
        }
    }

    /// Both ways it must be nearly the same.
    fn near(&mut self, what: &str, both: [f64; 2], bound: f64) {
        let [real, stepped] = both;
        // What is not a number is not near to anything.
        let off = (real - stepped).abs().partial_cmp(&bound);
        if off.is_none_or(Ordering::is_gt) {
            self.differences.push(format!(
                "{what}: real {real:.3}, stepped {stepped:.3}, expected within {bound:.3}"
            ));
        }
    }

    fn print(&self) {
        let lateral_m = { self.lateral_error_m.iter() }
            .map(|(_, [real_m, stepped_m])| (real_m - stepped_m).abs())
            .fold(0.0, f64::max);
        onboard::say!(
            "{:>6}  {:>7.1}  {:>9.1}  {lateral_m:>12.3}  {:>8}  {}",
            self.seed,
            self.duration_s[0],
            self.duration_s[1],
            self.compared,
            match self.differences.join("; ") {
                none if none.is_empty() => "none".to_owned(),
                differences => differences,
            }
        );
        if let Some(stalls) = &self.stalled {
            onboard::say!("        times and lateral errors are not compared: {stalls}");
        }
    }
}

fn within_s(real_s: f64) -> f64 {
    DURATION_S.max(DURATION_SHARE * real_s)
}

fn goal(robot: &RobotSummary) -> String {
    format!("{} {} of {}", robot.id, robot.laps, robot.wanted)
}

/// Who had an area, in order. A grant that was given back without having been entered hangs on a moment: it was asked for
/// and not wanted any more a cycle later.
fn grants(area: &AreaSummary) -> Vec<String> {
    let given_back = |own: &Holding| own.entered_s.is_none() && own.released_s.is_some();
    let owners = area.owners.iter().filter(|own| !given_back(own));
    owners.map(|own| own.robot.clone()).collect()
}

fn net(coordination: &CoordinationSummary) -> String {
    format!("{} {}", coordination.id, coordination.situation)
}

/// What fired, in order; at once, in that of names: which of two that do not depend on each other comes first hangs on a
/// moment too.
fn firings(coordination: &CoordinationSummary) -> Vec<String> {
    let mut firings: Vec<&FiringSummary> = coordination.firings.iter().collect();
    for together in firings.chunk_by_mut(|one, next| (next.at_s - one.at_s).abs() <= AT_ONCE_S) {
        together.sort_by(|one, other| one.transition.cmp(&other.transition));
    }
    let names = firings.iter();
    names.map(|firing| firing.transition.clone()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn run() -> Summary {
        let holding = |robot: &str| Holding {
            area: "1".into(),
            robot: robot.into(),
            fence: 1,
            requested_s: None,
            granted_s: 1.0,
            entered_s: None,
            released_s: None,
            returned: false,
        };
        Summary {
            outcome: "done".into(),
            duration_s: 100.0,
            robots: vec![RobotSummary {
                id: "amr-1".into(),
                done_s: Some(90.0),
                max_lateral_error_m: 0.04,
                ..RobotSummary::default()
            }],
            areas: vec![AreaSummary {
                id: "1".into(),
                capacity: 1,
                owners: ["amr-1", "amr-2"].map(holding).to_vec(),
                longest_wait_s: 1.0,
            }],
            coordinations: vec![CoordinationSummary {
                number: 1,
                id: "overtaking".into(),
                net: "overtaking".into(),
                situation: "normal-ahead".into(),
                robots: Vec::new(),
                from_s: 10.0,
                duration_s: Some(20.0),
                firings: [("aside", 11.0), ("slow", 11.001), ("on", 19.0)]
                    .map(|(transition, at_s)| FiringSummary {
                        transition: transition.into(),
                        at_s,
                    })
                    .to_vec(),
                marking: Vec::new(),
            }],
            ..Summary::default()
        }
    }

    #[test]
    fn what_is_nearly_the_same_agrees() {
        let (real, mut stepped) = (run(), run());
        stepped.duration_s = 101.9;
        stepped.robots[0].max_lateral_error_m = 0.06;
        let given_back = Holding {
            released_s: Some(1.001),
            ..stepped.areas[0].owners[1].clone()
        };
        stepped.areas[0].owners.insert(0, given_back);
        stepped.coordinations[0].firings.swap(0, 1);
        let pair = compare(&real, &stepped);
        assert_eq!(pair.differences, [""; 0]);
        assert!(pair.compared >= 5);
    }

    #[test]
    fn times_of_a_machine_that_stalled_are_not_compared() {
        let (mut real, mut stepped) = (run(), run());
        (real.duration_s, real.robots[0].done_s) = (107.0, Some(97.0));
        for (longest_ms, differences) in [(14.0, 2), (100.0, 0)] {
            real.stalls = Some(Stalls {
                count: 6,
                longest_ms,
                steal_ms: 0.0,
            });
            let pair = compare(&real, &stepped);
            assert_eq!(pair.differences.len(), differences, "{pair:?}");
            assert_eq!(pair.stalled.is_some(), differences == 0);
        }
        stepped.areas[0].owners.reverse();
        let pair = compare(&real, &stepped);
        assert!(pair.differences[0].contains("grants of area 1"));
    }

    #[test]
    fn each_difference_is_told() {
        type Change = fn(&mut Summary);
        let changes: [(Change, &str); 9] = [
            (|run| run.outcome = "stuck".into(), "outcome"),
            (|run| run.robots[0].wanted = 2, "goals"),
            (|run| run.areas[0].owners.reverse(), "grants of area 1"),
            (|run| run.coordinations.clear(), "coordinations"),
            (|run| run.coordinations[0].firings.clear(), "firings of"),
            (|run| run.coordinations[0].firings.swap(1, 2), "firings of"),
            (|run| run.duration_s = 104.0, "duration"),
            (|run| run.robots[0].done_s = None, "goal of amr-1"),
            (|run| run.robots[0].max_lateral_error_m = 0.2, "lateral"),
        ];
        for (change, told) in changes {
            let mut stepped = run();
            change(&mut stepped);
            let pair = compare(&run(), &stepped);
            let [only] = pair.differences.as_slice() else {
                panic!("{told}: {:?}", pair.differences);
            };
            assert!(only.contains(told), "{only}");
        }
    }
}
