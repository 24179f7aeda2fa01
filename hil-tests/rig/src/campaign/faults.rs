//! Each kind of fault many times while robots drive, and each pair of kinds once: `rig campaign faults`.

use std::collections::BTreeMap;
use std::sync::atomic::{AtomicBool, Ordering};

use onboard::cli::Failure;
use onboard::symbols::faults::Fault;
use serde::Serialize;

use super::cases::{Case, Moments, MomentsOfSeeds};
use super::expected::{Expected, Said, expected};
use super::shrink::{MOST, Shrunk};
use super::stepped::{Faults, Setup, runs};
use crate::machine::Machine;
use crate::output::write_json;
use crate::scenario::{Scenario, ScriptedFault, ScriptedKind};
use crate::stepped::Plans;
use crate::summary::Summary;

/// Of the faults that a case raised this many are printed.
const MOST_PRINTED: usize = 4;

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

/// Makes the runs of each case, and of pairs where they are wanted; leaves `faults.json`, and a folder for each case, with
/// which an interrupted campaign goes on.
///
/// # Errors
/// [`Failure::Refused`] when a run cannot be built, [`Failure::Failed`] when one was unsafe or hung, or robots did not raise what they
/// must for a case.
pub fn faults(
    scenario: &Scenario,
    plans: &Plans,
    setup: &Setup<'_>,
    times: &Times,
    asked_to_end: &AtomicBool,
) -> Result<(), Failure> {
    let moments = MomentsOfSeeds::default();
    let campaign = Campaign {
        moments: &moments,
        scenario,
        plans,
        setup,
        asked_to_end,
    };
    let cases = times.cases(scenario)?;
    onboard::say!(
        "{:<24} {:>5} {:>7} {:>5}   raised, in how many runs",
        "fault",
        "runs",
        "unsafe",
        "hung"
    );
    let mut rows = Vec::new();
    for case in &cases {
        let draw = |seed: u64| {
            let drawn = case.draw(scenario, seed, &campaign.moments(seed)?);
            Ok(drawn.into_iter().collect())
        };
        let expected = Some(expected(case));
        rows.push(campaign.row(&case.to_string(), times.runs, expected, &draw)?);
        if campaign.is_interrupted() {
            break;
        }
    }
    let pairs: Vec<[&Case; 2]> = { cases.iter().enumerate() }
        .flat_map(|(number, one)| cases[number + 1..].iter().map(move |other| [one, other]))
        .collect();
    if times.pairs && !campaign.is_interrupted() {
        let draw = |seed: u64| {
            let pair = pairs[(seed - setup.seeds.start) as usize];
            let drawn = Case::draw_pair(pair, scenario, seed, &campaign.moments(seed)?);
            Ok(drawn.into_iter().flatten().collect())
        };
        rows.push(campaign.row("pairs", pairs.len(), None, &draw)?);
    }
    campaign.report(&rows)?;
    if campaign.is_interrupted() {
        let why = "interrupted: the same command goes on from there";
        return Err(Failure::failed(why));
    }
    let count = |of: fn(&Row) -> usize| rows.iter().map(of).sum::<usize>();
    let unnoticed = count(|row| usize::from(!row.missing.is_empty()));
    match (count(|row| row.dangerous), count(|row| row.hung), unnoticed) {
        (0, 0, 0) => Ok(()),
        (dangerous, hung, unnoticed) => Err(Failure::failed(format_args!(
            "{dangerous} runs were unsafe, {hung} did not come to their goals; {unnoticed} kinds were not noticed when they had to be"
        ))),
    }
}

struct Campaign<'a> {
    moments: &'a MomentsOfSeeds,
    scenario: &'a Scenario,
    plans: &'a Plans,
    setup: &'a Setup<'a>,
    asked_to_end: &'a AtomicBool,
}

impl Campaign<'_> {
    /// What happens in the run of a seed without faults.
    fn moments(&self, seed: u64) -> Result<Moments, Failure> {
        self.moments.of(self.scenario, self.plans, seed)
    }

    fn is_interrupted(&self) -> bool {
        self.asked_to_end.load(Ordering::Relaxed)
    }

    /// Makes the runs of a case, each with the faults that are drawn from its seed.
    fn row(
        &self,
        case: &str,
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
            faults: Faults::Of(case, &faults),
            out: &out,
            ..self.setup.clone()
        };
        let (summaries, elapsed_s) = runs(self.scenario, self.plans, &setup, self.asked_to_end)?;
        let drawn = { summaries.iter() }
            .map(|run| {
                let raised = self.moments(run.seed)?.raised_besides(run);
                Ok((run, draw(run.seed)?, raised))
            })
            .collect::<Result<Vec<_>, Failure>>()?;
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
            elapsed_s,
            bad: Vec::new(),
        };
        let (mut reasons, mut failed) = (Vec::new(), Vec::new());
        for run in summaries.iter().filter(|run| !run.passed()) {
            let all = setup.faults.add(self.scenario, run.seed)?.faults;
            if is_bad(run, &all) {
                let is_unsafe = !run.violations.is_empty();
                row.dangerous += usize::from(is_unsafe);
                row.hung += usize::from(!is_unsafe);
                reasons.push(run.reason());
                failed.push((run, all));
            }
        }
        let shrinker = setup.shrinker(self.scenario, self.plans, self.asked_to_end);
        let again = shrinker.shrink(&failed, is_bad)?;
        row.bad = { reasons.into_iter().zip(again) }
            .map(|(reason, again)| BadRun { reason, again })
            .collect();
        row.print();
        Ok(row)
    }

    fn report(&self, rows: &[Row]) -> Result<(), Failure> {
        let was = |fault: &Fault| {
            let mut raised = rows.iter().flat_map(|row| &row.raised);
            raised.any(|(name, _)| name == fault.name())
        };
        let never = Fault::ALL.into_iter().filter(|fault| !was(fault));
        let report = Report {
            scenario: &self.scenario.name,
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
        Ok(())
    }
}

/// How often each is there, most first.
fn counted<'a>(names: impl Iterator<Item = &'a &'a str>) -> Vec<(String, usize)> {
    let mut counts = BTreeMap::<&str, usize>::new();
    for name in names {
        *counts.entry(name).or_default() += 1;
    }
    let mut counts: Vec<(String, usize)> = { counts.into_iter() }
        .map(|(name, count)| (name.to_owned(), count))
        .collect();
    counts.sort_by_key(|(_, count)| std::cmp::Reverse(*count));
    counts
}

impl Row {
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
