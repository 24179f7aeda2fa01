//! Each kind of fault many times while robots drive, or dock, and each pair of kinds once: `rig campaign faults`.

use std::collections::BTreeMap;
use std::sync::atomic::{AtomicBool, Ordering};

use onboard::cli::Failure;
use onboard::symbols::faults::Fault;
use serde::Serialize;

use super::cases::{Case, Does, Moments, MomentsOfSeeds};
use super::expected::{Expected, Said, expected};
use super::pool::run_all;
use super::shrink::{Again, MOST, Shrunk};
use super::stepped::{Faults, Setup, runs};
use crate::machine::Machine;
use crate::output::write_json;
use crate::scenario::{Scenario, ScriptedFault, ScriptedKind};
use crate::stepped::Plans;
use crate::summary::Summary;

/// Of the faults that a case raised this many are printed.
const MOST_PRINTED: usize = 4;
/// Among so many runs there are some in which a fault can show.
const ENOUGH_RUNS: usize = 50;

/// How often.
#[derive(Clone, Debug)]
pub struct Times {
    /// Each kind.
    pub runs: usize,
    /// Each pair of kinds once, besides.
    pub pairs: bool,
    /// Only these kinds; all if there are none.
    pub only: Vec<String>,
}

impl Times {
    /// The kinds that are wanted.
    fn cases(&self, scenario: &Scenario) -> Result<Vec<Case>, Failure> {
        let mut cases = Case::all(scenario);
        let names: Vec<String> = cases.iter().map(Case::to_string).collect();
        if let Some(unknown) = { self.only.iter() }.find(|name| !names.contains(name)) {
            return Err(Failure::refused(format_args!(
                "--only: found `{unknown}`, expected some of: {}",
                names.join(", ")
            )));
        }
        cases.retain(|case| self.only.is_empty() || self.only.contains(&case.to_string()));
        Ok(cases)
    }
}

/// Where runs are made.
pub struct Ground {
    scenario: Scenario,
    plans: Plans,
    again: Again,
    moments: MomentsOfSeeds,
}

impl Ground {
    /// Runs of a scenario with these plans; what makes them again, but for seeds and faults.
    #[must_use]
    pub fn new(scenario: Scenario, plans: Plans, again: Again) -> Self {
        Self {
            scenario,
            plans,
            again,
            moments: MomentsOfSeeds::default(),
        }
    }
}

/// `faults.json`.
#[derive(Debug, Serialize)]
struct Report<'a> {
    scenario: &'a str,
    machine: Machine,
    rows: &'a [Row],
    /// Faults of the robots' table that no run raised.
    never_raised: Vec<&'static str>,
}

/// What came out of the runs of one case, or of all pairs.
#[derive(Debug, Serialize)]
struct Row {
    case: String,
    runs: usize,
    /// Runs with a violation.
    #[serde(rename = "unsafe")]
    dangerous: usize,
    /// Runs that did not come to their goals, where a fleet must.
    hung: usize,
    /// Faults of the robots' table, and in how many runs they were raised; most first.
    raised: Vec<(String, usize)>,
    /// Faults of that table of which robots must raise one for this case, and raised none
    missing: Vec<&'static str>,
    /// in the runs of these seeds.
    silent: Vec<u64>,
    /// In how many runs it could show, where robots must raise one.
    shows: Option<usize>,
    elapsed_s: f64,
    /// Runs that were unsafe or hung.
    bad: Vec<BadRun>,
}

/// A run that was unsafe or hung.
#[derive(Debug, Serialize)]
struct BadRun {
    reason: String,
    /// How to see it again.
    #[serde(flatten)]
    again: Shrunk,
}

/// Makes the runs of each case, and of pairs where they are wanted, where robots drive and where they dock; leaves `faults.json`, and a
/// folder for each case, with which an interrupted campaign goes on.
///
/// # Errors
/// [`Failure::Refused`] when a run cannot be built, [`Failure::Failed`] when one was unsafe or hung, or robots did not raise what they
/// must for a case.
pub fn faults(
    [driving, docking]: [&Ground; 2],
    setup: &Setup<'_>,
    times: &Times,
    asked_to_end: &AtomicBool,
) -> Result<(), Failure> {
    let campaign = |ground| Campaign {
        ground,
        setup,
        asked_to_end,
    };
    let of = |does| match does {
        Does::Drive => campaign(driving),
        Does::Dock => campaign(docking),
    };
    let is_interrupted = || asked_to_end.load(Ordering::Relaxed);
    let cases = times.cases(&driving.scenario)?;
    onboard::say!(
        "{:<24} {:>5} {:>7} {:>5}   raised, in how many runs",
        "fault",
        "runs",
        "unsafe",
        "hung"
    );
    let mut rows = Vec::new();
    for case in &cases {
        let campaign = of(case.does);
        let draw = |seed: u64| {
            let moments = campaign.moments(seed)?;
            let drawn = case.draw(&campaign.ground.scenario, seed, &moments);
            Ok(drawn.into_iter().collect())
        };
        let expected = Some(expected(case));
        let name = case.to_string();
        rows.push(campaign.row([&name; 2], times.runs, expected, &draw)?);
        if is_interrupted() {
            break;
        }
    }
    for (does, name) in [(Does::Drive, "pairs"), (Does::Dock, "pairs docked")] {
        let (campaign, pairs) = (of(does), pairs(&cases, does));
        if !times.pairs || pairs.is_empty() || is_interrupted() {
            continue;
        }
        let draw = |seed: u64| {
            let pair = pairs[(seed - setup.seeds.start) as usize];
            let moments = campaign.moments(seed)?;
            let drawn = Case::draw_pair(pair, &campaign.ground.scenario, seed, &moments);
            Ok(drawn.into_iter().flatten().collect())
        };
        // Which pair a seed stands for hangs on all of them.
        let all = pairs.iter().map(|[one, other]| format!("{one}+{other}"));
        let all: Vec<String> = all.collect();
        let identity = format!("{name} from {}: {}", setup.seeds.start, all.join(" "));
        rows.push(campaign.row([name, &identity], pairs.len(), None, &draw)?);
    }
    let never = campaign(driving).report(&rows)?;
    if is_interrupted() {
        let why = "interrupted: the same command goes on from there";
        return Err(Failure::failed(why));
    }
    let count = |of: fn(&Row) -> usize| rows.iter().map(of).sum::<usize>();
    let unnoticed = count(|row| usize::from(row.is_unnoticed()));
    // Of all kinds often enough each fault of the robots' table must come.
    let all = times.only.is_empty() && times.runs >= ENOUGH_RUNS;
    let never = if all { never } else { Vec::new() };
    match (
        count(|row| row.dangerous),
        count(|row| row.hung),
        unnoticed,
        never.len(),
    ) {
        (0, 0, 0, 0) => Ok(()),
        (dangerous, hung, unnoticed, never) => Err(Failure::failed(format_args!(
            "{dangerous} runs were unsafe, {hung} did not come to their goals; {unnoticed} kinds were not noticed when they had to be, or could \
             never show; {never} faults of the robots' table were never raised"
        ))),
    }
}

/// Each two cases: those of which one is of a robot that docks, which comes first, or all others.
fn pairs(cases: &[Case], does: Does) -> Vec<[&Case; 2]> {
    let all = { cases.iter().enumerate() }
        .flat_map(|(number, one)| cases[number + 1..].iter().map(move |other| [one, other]));
    let docks = |case: &Case| case.does == Does::Dock;
    all.map(|[one, other]| {
        if docks(other) {
            [other, one]
        } else {
            [one, other]
        }
    })
    .filter(|[one, _]| one.does == does)
    .collect()
}

struct Campaign<'a> {
    ground: &'a Ground,
    setup: &'a Setup<'a>,
    asked_to_end: &'a AtomicBool,
}

impl Campaign<'_> {
    /// What happens in the run of a seed without faults.
    fn moments(&self, seed: u64) -> Result<Moments, Failure> {
        let Ground {
            scenario,
            plans,
            moments,
            ..
        } = self.ground;
        moments.of(scenario, plans, seed)
    }

    /// Makes the runs of a case, each with the faults that are drawn from its seed; its identity decides which these are.
    fn row(
        &self,
        [case, identity]: [&str; 2],
        count: usize,
        expected: Option<Expected>,
        draw: &(dyn Fn(u64) -> Result<Vec<ScriptedFault>, Failure> + Sync),
    ) -> Result<Row, Failure> {
        let out = self.setup.out.join(case.replace(' ', "-"));
        let first = self.setup.seeds.start;
        let faults = |seed: u64| {
            let faults = draw(seed)?;
            if faults.is_empty() {
                let why = format!("seed {seed}: no robot drives, so that no fault can meet one");
                return Err(Failure::refused(why));
            }
            Ok(faults)
        };
        let setup = Setup {
            seeds: first..first + count as u64,
            faults: Faults::Of(identity, &faults),
            again: self.ground.again.clone(),
            out: &out,
            ..self.setup.clone()
        };
        let Ground {
            scenario, plans, ..
        } = self.ground;
        let (summaries, elapsed_s) = runs(scenario, plans, &setup, self.asked_to_end)?;
        // Of runs that were made before, those without faults are made again, which takes as long as the runs did.
        let look = |number: usize| {
            let run: &Summary = &summaries[number];
            let moments = self.moments(run.seed)?;
            Ok((run, draw(run.seed)?, moments.raised_besides(run)))
        };
        let (count, never) = (summaries.len(), AtomicBool::new(false));
        let drawn = run_all(count, setup.jobs, &never, look, |_, _| {})?;
        let said: Vec<Said<'_>> = { drawn.iter() }
            .flat_map(|(run, faults, raised)| {
                faults.iter().map(|fault| Said {
                    seed: run.seed,
                    duration_s: run.duration_s,
                    fault,
                    raised: raised.clone(),
                })
            })
            .collect();
        let shows = expected.and_then(|own| own.shows_in(&said));
        let missing = expected.and_then(|own| own.missing(&said));
        let missing = missing.unwrap_or_default();
        let mut row = Row {
            case: case.to_owned(),
            runs: summaries.len(),
            dangerous: 0,
            hung: 0,
            raised: counted(drawn.iter().flat_map(|(_, _, raised)| raised)),
            missing: missing.any_of.iter().map(|own| own.name()).collect(),
            silent: missing.silent,
            shows,
            elapsed_s,
            bad: Vec::new(),
        };
        let (mut reasons, mut failed) = (Vec::new(), Vec::new());
        for run in summaries.iter().filter(|run| !run.passed()) {
            let all = setup.faults.add(scenario, run.seed)?.faults;
            if is_bad(run, &all) {
                let is_unsafe = !run.violations.is_empty();
                row.dangerous += usize::from(is_unsafe);
                row.hung += usize::from(!is_unsafe);
                reasons.push(run.reason());
                failed.push((run, all));
            }
        }
        let shrinker = setup.shrinker(scenario, plans, self.asked_to_end);
        let again = shrinker.shrink(&failed, is_bad)?;
        row.bad = { reasons.into_iter().zip(again) }
            .map(|(reason, again)| BadRun { reason, again })
            .collect();
        row.print();
        Ok(row)
    }

    /// Leaves `faults.json`, and returns the faults of the robots' table that were never raised.
    fn report(&self, rows: &[Row]) -> Result<Vec<&'static str>, Failure> {
        let was = |fault: &Fault| {
            let mut raised = rows.iter().flat_map(|row| &row.raised);
            raised.any(|(name, _)| name == fault.name())
        };
        let never = Fault::ALL.into_iter().filter(|fault| !was(fault));
        let report = Report {
            scenario: &self.ground.scenario.name,
            machine: Machine::here(),
            rows,
            never_raised: never.map(Fault::name).collect(),
        };
        let runs: usize = rows.iter().map(|row| row.runs).sum();
        let elapsed_s: f64 = rows.iter().map(|row| row.elapsed_s).sum();
        onboard::say!(
            "{runs} runs in {elapsed_s:.0} s; never raised: {}",
            report.never_raised.join(", ")
        );
        let file = write_json(self.setup.out, "faults.json", &report)?;
        onboard::say!("wrote {}", file.display());
        Ok(report.never_raised)
    }
}

/// How often each is there, most first.
fn counted<'a>(names: impl Iterator<Item = &'a &'a str>) -> Vec<(String, usize)> {
    let mut counts = BTreeMap::<String, usize>::new();
    for &name in names {
        *counts.entry(name.to_owned()).or_default() += 1;
    }
    let mut counts: Vec<_> = counts.into_iter().collect();
    counts.sort_by_key(|(_, count)| std::cmp::Reverse(*count));
    counts
}

impl Row {
    /// It was not raised when it had to be, or among many runs there was none in which it had to be.
    fn is_unnoticed(&self) -> bool {
        !self.missing.is_empty() || self.shows == Some(0) && self.runs >= ENOUGH_RUNS
    }

    fn print(&self) {
        let raised: Vec<String> = { self.raised.iter().take(MOST_PRINTED) }
            .map(|(fault, runs)| format!("{fault} {runs}"))
            .collect();
        onboard::say!(
            "{:<24} {:>5} {:>7} {:>5}   {}",
            self.case,
            self.runs,
            self.dangerous,
            self.hung,
            raised.join(", ")
        );
        if !self.missing.is_empty() {
            let seeds: Vec<String> = { self.silent.iter().take(MOST_PRINTED) }
                .map(u64::to_string)
                .collect();
            onboard::say!(
                "    {} not raised in {} runs, of seeds {}",
                self.missing.join(" or "),
                self.silent.len(),
                seeds.join(", ")
            );
        }
        if self.shows == Some(0) {
            onboard::say!("    in no run could it show");
        }
        for bad in self.bad.iter().take(MOST) {
            onboard::say!("    {}", bad.reason);
            bad.again.print();
        }
        if self.bad.len() > MOST {
            onboard::say!("    ... and {} more", self.bad.len() - MOST);
        }
    }
}

/// Whether a run with these faults was unsafe, or did not come to its goals where a fleet must.
fn is_bad(run: &Summary, faults: &[ScriptedFault]) -> bool {
    let lasting = |fault: &ScriptedFault| ScriptedKind::LASTING.contains(&fault.what);
    !run.violations.is_empty() || !run.is_done() && !faults.iter().any(lasting)
}
