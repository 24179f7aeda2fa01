//! Many runs on the simulated clock, in threads of this process.

use std::hash::{DefaultHasher, Hash, Hasher};
use std::io::{IsTerminal, Write};
use std::ops::Range;
use std::path::Path;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::time::UNIX_EPOCH;

use onboard::cli::Failure;
use serde::Serialize;

use super::ledger::{Head, Ledger};
use super::once::recorded;
use super::pool::run_all;
use super::shrink::{Again, Shrinker};
use super::statistics::Statistics;
use crate::machine::Machine;
use crate::output::write_json;
use crate::scenario::{Scenario, ScriptedFault};
use crate::stepped::Plans;
use crate::stepped::faults::faulted;
use crate::summary::Summary;

/// What a campaign is.
#[derive(Clone, Debug)]
pub struct Setup<'a> {
    /// The seeds of its runs.
    pub seeds: Range<u64>,
    /// What goes wrong besides what the scenario says.
    pub faults: Faults<'a>,
    /// The plans are with a mediator where the site asks for one.
    pub mediator: bool,
    /// The plans are with the site's nets.
    pub nets: bool,
    /// How many runs at once.
    pub jobs: usize,
    /// What makes its runs again, but for seeds and faults.
    pub again: Again,
    /// Make all runs, also those that were made before.
    pub fresh: bool,
    /// Folder for `campaign.json` and `runs.jsonl`.
    pub out: &'a Path,
}

impl<'a> Setup<'a> {
    /// What makes runs of the campaign again that failed, and leaves their reports in its folder.
    pub fn shrinker(
        &'a self,
        scenario: &'a Scenario,
        plans: &'a Plans,
        asked_to_end: &'a AtomicBool,
    ) -> Shrinker<'a> {
        Shrinker {
            scenario,
            plans,
            again: &self.again,
            jobs: self.jobs,
            out: self.out,
            asked_to_end,
        }
    }
}

/// What goes wrong in the runs of a campaign.
#[derive(Clone, Copy)]
pub enum Faults<'a> {
    /// Nothing.
    None,
    /// Any kinds, drawn from each seed.
    Drawn,
    /// Those of a case with this name, which say what they are for each seed.
    Of(&'a str, &'a DrawFaults<'a>),
}

/// Draws faults from a seed.
pub type DrawFaults<'a> = dyn Fn(u64) -> Result<Vec<ScriptedFault>, Failure> + Sync + 'a;

impl Faults<'_> {
    /// The scenario with these faults beside its own.
    pub(super) fn add(&self, scenario: &Scenario, seed: u64) -> Result<Scenario, Failure> {
        Ok(match self {
            Self::None => scenario.clone(),
            Self::Drawn => faulted(scenario, seed),
            Self::Of(_, draw) => {
                let mut scenario = scenario.clone();
                scenario.faults.extend(draw(seed)?);
                scenario
            }
        })
    }
}

impl std::fmt::Display for Faults<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::None => f.pad("none"),
            Self::Drawn => f.pad("drawn"),
            Self::Of(case, _) => f.pad(case),
        }
    }
}

impl std::fmt::Debug for Faults<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{self}")
    }
}

/// `campaign.json`.
#[derive(Debug, Serialize)]
struct Report<'a> {
    /// What the command line changes in the scenario.
    arguments: &'a [String],
    machine: Machine,
    jobs: usize,
    /// First and last.
    seeds: [u64; 2],
    /// What went wrong besides what the scenario says: `none`, or `drawn` from the seeds.
    faults_of_seeds: String,
    #[serde(flatten)]
    statistics: &'a Statistics,
}

/// Runs a scenario many times; leaves `campaign.json`, also when it is asked to end.
///
/// # Errors
/// As [`runs`].
pub fn campaign(
    scenario: &Scenario,
    plans: &Plans,
    setup: &Setup<'_>,
    asked_to_end: &AtomicBool,
) -> Result<Statistics, Failure> {
    let (summaries, elapsed_s) = runs(scenario, plans, setup, asked_to_end)?;
    let failed = { summaries.iter() }
        .filter(|run| !run.passed())
        .map(|run| Ok((run, setup.faults.add(scenario, run.seed)?.faults)))
        .collect::<Result<Vec<_>, Failure>>()?;
    if !failed.is_empty() && !asked_to_end.load(Ordering::Relaxed) {
        onboard::say!("{} runs failed, and are made again", failed.len());
    }
    let shrinker = setup.shrinker(scenario, plans, asked_to_end);
    let shrunk = shrinker.shrink(&failed, |run, _| !run.passed())?;
    let statistics = Statistics::of(scenario, &summaries, elapsed_s, shrunk);
    statistics.print();
    let report = Report {
        arguments: &setup.again.arguments,
        machine: Machine::here(),
        jobs: setup.jobs,
        seeds: [setup.seeds.start, setup.seeds.end - 1],
        faults_of_seeds: setup.faults.to_string(),
        statistics: &statistics,
    };
    let file = write_json(setup.out, "campaign.json", &report)?;
    onboard::say!("wrote {}", file.display());
    Ok(statistics)
}

/// Runs a scenario many times, until it is asked to end; returns what came out of the runs, and how long they took. Runs that an
/// earlier campaign of the same kind has left in the folder are not made again.
///
/// # Errors
/// [`Failure::Refused`] when a run cannot be built, [`Failure::Failed`] when it cannot be written down.
pub fn runs(
    scenario: &Scenario,
    plans: &Plans,
    setup: &Setup<'_>,
    asked_to_end: &AtomicBool,
) -> Result<(Vec<Summary>, f64), Failure> {
    let ledger = Ledger::open(setup.out, &head(scenario, setup), setup.fresh)?;
    let before = { setup.seeds.clone() }.filter_map(|seed| ledger.passed_before(seed));
    let before: Vec<bool> = before.collect();
    let seeds = { setup.seeds.clone() }.filter(|seed| ledger.passed_before(*seed).is_none());
    let seeds: Vec<u64> = seeds.collect();
    let runs = before.len() + seeds.len();
    if let Some(why) = ledger.starts_over() {
        onboard::say!("starts over: {why}");
    }
    if !before.is_empty() {
        let made = before.len();
        onboard::say!("resumed: {made} of {runs} runs were made before");
    }
    let failed = AtomicUsize::new(before.iter().filter(|passed| !**passed).count());
    let terminal = std::io::stdout().is_terminal();
    let one = |number: usize| {
        let seed = seeds[number];
        let scenario = setup.faults.add(scenario, seed)?;
        let summary = summary(&scenario, plans, seed, true)?;
        failed.fetch_add(usize::from(!summary.passed()), Ordering::Relaxed);
        ledger.add(summary)
    };
    let show = |_: &(), made: usize| {
        if terminal {
            let (name, done) = (&scenario.name, before.len() + made);
            let failed = failed.load(Ordering::Relaxed);
            // A closed terminal is no reason to stop.
            let mut out = std::io::stdout().lock();
            let _ = write!(
                out,
                "\r\x1b[K{name}: {done} of {runs} runs, {failed} failed"
            );
            let _ = out.flush();
        }
    };
    let made = run_all(seeds.len(), setup.jobs, asked_to_end, one, show);
    if terminal {
        let _ = write!(std::io::stdout(), "\r\x1b[K");
    }
    made?;
    ledger.runs(&setup.seeds)
}

/// What decides the runs of a campaign, but for their seeds.
fn head(scenario: &Scenario, setup: &Setup<'_>) -> Head {
    let mut hasher = DefaultHasher::new();
    // All that was read from files, with what the command line changes in it.
    format!("{scenario:?}").hash(&mut hasher);
    Head {
        scenario: scenario.name.clone(),
        files: format!("{:016x}", hasher.finish()),
        faults: setup.faults.to_string(),
        mediator: setup.mediator,
        nets: setup.nets,
        program: program(),
    }
}

/// Version and build: size and age of the executable, which is cheaper than to read all of it.
fn program() -> String {
    let executable = std::fs::metadata("/proc/self/exe").ok();
    let bytes = executable.as_ref().map_or(0, std::fs::Metadata::len);
    let changed = executable.and_then(|own| own.modified().ok());
    let since = changed.and_then(|time| time.duration_since(UNIX_EPOCH).ok());
    let ns = since.unwrap_or_default().as_nanos();
    format!("{} of {bytes} bytes at {ns} ns", env!("CARGO_PKG_VERSION"))
}

/// One run on the simulated clock, and what came out. A robot that does not heed leave is a control.
///
/// # Errors
/// [`Failure::Refused`] when it cannot be built.
pub fn summary(
    scenario: &Scenario,
    plans: &Plans,
    seed: u64,
    heeds_leave: bool,
) -> Result<Summary, Failure> {
    Ok(recorded(scenario, plans, seed, heeds_leave)?.summary)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::stepped::faults::drawn;
    use crate::testing;

    #[test]
    fn faults_of_seeds_come_beside_those_of_the_scenario() {
        let mut scenario = testing::scenario("overtaking");
        let own = "at_s = 4.0\nfor_s = 1.0\nwhat = \"reset\"\nrobot = \"amr-1\"";
        scenario.faults = vec![toml::from_str(own).expect("a fault")];
        let of = |faults: Faults<'_>, seed| faults.add(&scenario, seed).expect("faults").faults;
        assert_eq!(of(Faults::None, 4), scenario.faults);
        let expected = [scenario.faults.clone(), drawn(&scenario, 4)].concat();
        assert_eq!(of(Faults::Drawn, 4), expected);
        assert!(expected.len() > 1);
        assert_ne!(of(Faults::Drawn, 5), expected);
    }
}
