//! `rig agreement`: whether stepped runs and runs of the real programs come to the same, seed by seed.
//!
//! Each seed that a campaign of the real programs has left is run again on the simulated clock. The order of grants of each
//! area, what fired in each coordination and in which order, and what was violated must be the same; durations and lateral errors
//! may differ by what real threads, a real network and a real kernel make of the times of messages and cycles. Where the machine
//! stalled in the real run they are not compared, which is said; nor are violations that may come of a stall.

mod order;
#[cfg(test)]
mod tests;

use std::cmp::Ordering;
use std::collections::BTreeSet;
use std::fs;
use std::path::Path;

use config::NetConfig;
use onboard::cli::Failure;
use serde::Serialize;

use self::order::Touched;
use super::stepped;
use crate::machine::Machine;
use crate::output::write_json;
use crate::scenario::Scenario;
use crate::stalls::Stalls;
use crate::stepped::Plans;
use crate::summary::{AreaSummary, CoordinationSummary, Holding, RobotSummary, Summary};

/// Durations, and the times at which robots reach their goals, differ by at most this
const DURATION_S: f64 = 2.0;
/// and this share of the real one.
const DURATION_SHARE: f64 = 0.02;
/// Largest lateral errors differ by at most this.
const LATERAL_M: f64 = 0.03;

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
    /// Seeds whose times and lateral errors were compared as well,
    timed: usize,
    /// and how many that had to be.
    asked: usize,
    pairs: &'a [Pair],
}

/// Steps every seed that has a folder with a summary in `real`, named by it, and compares; leaves `agreement.json` there. Times and
/// lateral errors must have been compared in `timed` seeds at least, or in all of them.
///
/// # Errors
/// [`Failure::Refused`] when there is no such folder or a run cannot be built, [`Failure::Failed`] when they do not agree.
pub fn agreement(
    scenario: &Scenario,
    plans: &Plans,
    real: &Path,
    timed: Option<usize>,
) -> Result<(), Failure> {
    let summaries = summaries(scenario, real)?;
    onboard::say!("  seed   real s  stepped s  lateral off m  compared  differences");
    let mut pairs = Vec::new();
    for summary in &summaries {
        let stepped = stepped::summary(scenario, plans, summary.seed, true)?;
        let pair = compare(&scenario.nets, summary, &stepped);
        pair.print();
        pairs.push(pair);
    }
    let agreeing = pairs.iter().filter(|pair| pair.differences.is_empty());
    let agreeing = agreeing.count();
    let untimed = pairs.iter().filter(|pair| pair.stalled.is_some());
    let untimed: Vec<u64> = untimed.map(|pair| pair.seed).collect();
    let asked = timed.unwrap_or(pairs.len());
    let report = Report {
        scenario: &scenario.name,
        machine: Machine::here(),
        agreeing,
        timed: pairs.len() - untimed.len(),
        asked,
        pairs: &pairs,
    };
    let file = write_json(real, "agreement.json", &report)?;
    onboard::say!(
        "{agreeing} of {} seeds agree; times and lateral errors were compared in {}",
        pairs.len(),
        report.timed
    );
    onboard::say!("wrote {}", file.display());
    verdict(pairs.len(), agreeing, &untimed, asked)
}

/// Whether so many agreeing pairs are agreement, where times were compared in all but these seeds, and were to be in so many.
fn verdict(pairs: usize, agreeing: usize, untimed: &[u64], asked: usize) -> Result<(), Failure> {
    if agreeing < pairs {
        let apart = pairs - agreeing;
        let why = format_args!("{apart} of {pairs} seeds do not agree");
        return Err(Failure::failed(why));
    }
    let timed = pairs - untimed.len();
    if timed >= asked {
        return Ok(());
    }
    let again = if untimed.is_empty() {
        format!("there are {pairs} real runs: make more")
    } else {
        let seeds: Vec<String> = untimed.iter().map(ToString::to_string).collect();
        let seeds = seeds.join(", ");
        format!(
            "the machine stalled in the real runs of seeds {seeds}: make them again while it is quiet (`rig campaign` with --runs 1 --seed N)"
        )
    };
    Err(Failure::failed(format_args!(
        "times and lateral errors were compared in {timed} seeds, expected in {asked}; {again} (--timed N: fewer are enough, --untimed: orders alone are)"
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
        let path = entry.path().join("summary.json");
        let text = fs::read_to_string(&path).map_err(|error| {
            refused(format!(
                "{}: {error}: a run that did not come to its end is no run to compare, make it again",
                path.display()
            ))
        })?;
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

fn compare(nets: &[NetConfig], real: &Summary, stepped: &Summary) -> Pair {
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
    let stalls = real.stalls.filter(Stalls::spoil);
    pair.same(
        "violations",
        [real, stepped].map(|run| violations(run, stalls.is_some())),
    );
    let ids = |run: &Summary| run.areas.iter().map(|area| area.id.clone()).collect();
    pair.same("areas", [real, stepped].map(ids));
    for (one, other) in real.areas.iter().zip(&stepped.areas) {
        let what = format!("grants of area {}", one.id);
        pair.same(&what, [one, other].map(grants));
    }
    let begun = |run: &Summary| run.coordinations.iter().map(net).collect();
    pair.same("coordinations", [real, stepped].map(begun));
    for (one, other) in real.coordinations.iter().zip(&stepped.coordinations) {
        pair.compared += one.firings.len();
        let touched = Touched::by(nets.iter().find(|own| own.name == one.net));
        if let Some(difference) = touched.difference(&one.firings, &other.firings) {
            let difference = format!("firings of {} {}: {difference}", one.id, one.number);
            pair.differences.push(difference);
        }
    }
    // What was late then is no difference between the programs and the simulation: only orders are compared.
    if let Some(stalls) = stalls {
        pair.stalled = Some(stalls);
        return pair;
    }
    pair.near(
        "duration in seconds",
        pair.duration_s,
        within_s(real.duration_s),
    );
    for (one, other) in real.coordinations.iter().zip(&stepped.coordinations) {
        let both = [one.duration_s, other.duration_s];
        // Neither was over when its run ended.
        if both != [None; 2] {
            let what = format!("duration of {} {} in seconds", one.id, one.number);
            let [one_s, other_s] = both.map(|own| own.unwrap_or(f64::NAN));
            pair.near(&what, [one_s, other_s], within_s(one_s));
        }
    }
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

/// What was violated by whom, each once, in the order of names.
fn violations(run: &Summary, stalled: bool) -> Vec<String> {
    let judged =
        { run.violations.iter() }.filter(|own| !stalled || !own.kind.may_come_of_a_stall());
    let named: BTreeSet<String> = judged
        .map(|own| format!("{} of {}", own.kind, own.robot))
        .collect();
    named.into_iter().collect()
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
