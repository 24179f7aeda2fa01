//! Runs that failed, once more: the command that makes each again, the fewest faults with which it still fails, and its report.

use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};

use onboard::cli::Failure;
use serde::Serialize;

use super::once::recorded;
use super::pool::run_all;
use crate::output::make_folder;
use crate::run::leave;
use crate::scenario::{Scenario, ScriptedFault};
use crate::stepped::Plans;
use crate::summary::Summary;
use crate::violation::ViolationKind;

/// At most this many failed runs are shrunk and printed: each costs a few runs more.
pub(super) const MOST: usize = 25;

/// The command line that makes a stepped run of a scenario, but for its seed and faults.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Again {
    /// The scenario as `rig scenario` takes it: its file, or the name of one that ships.
    pub scenario: PathBuf,
    /// What the command line changes in it.
    pub arguments: Vec<String>,
    /// The scenario's file has faults of its own.
    pub has_faults: bool,
}

impl Again {
    /// The command that makes the run of a seed with these faults and no others.
    #[must_use]
    pub fn command(&self, seed: u64, faults: &[ScriptedFault]) -> String {
        let mut words = vec![quoted(&self.scenario.display().to_string())];
        words.extend(self.arguments.iter().map(|word| quoted(word)));
        words.push(format!("--stepped --seed {seed}"));
        words.extend(self.has_faults.then(|| "--without-faults".to_owned()));
        let faults = faults.iter().map(ToString::to_string);
        words.extend(faults.map(|fault| format!("--fault {}", quoted(&fault))));
        format!("rig scenario {}", words.join(" "))
    }
}

/// A word as a shell takes it.
fn quoted(word: &str) -> String {
    let plain = |char: char| char.is_ascii_alphanumeric() || "-_./=:,+%@".contains(char);
    if !word.is_empty() && word.chars().all(plain) {
        word.to_owned()
    } else {
        format!("'{}'", word.replace('\'', r"'\''"))
    }
}

/// A failed run, made smaller.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Shrunk {
    /// Makes it again.
    pub command: String,
    /// With this many faults it fails,
    pub faults: usize,
    /// of this many.
    pub of_faults: usize,
    /// Its report; none where there were too many failed runs, or no time was left.
    pub report: Option<PathBuf>,
}

/// What is needed to make failed runs again.
pub struct Shrinker<'a> {
    /// The scenario.
    pub scenario: &'a Scenario,
    /// What its robots run.
    pub plans: &'a Plans,
    /// What makes the runs again elsewhere.
    pub again: &'a Again,
    /// How many at once.
    pub jobs: usize,
    /// Gets a folder with the report of each.
    pub out: &'a Path,
    /// From then on only the commands are wanted.
    pub asked_to_end: &'a AtomicBool,
}

impl Shrinker<'_> {
    /// Shrinks failed runs, each with all its faults; `fails` tells from what came out of a run with some of these whether it failed. One
    /// that fails otherwise than before is another run. The results have the order of the runs.
    ///
    /// # Errors
    /// [`Failure::Refused`] when a run cannot be built, [`Failure::Failed`] when its report cannot be written.
    pub fn shrink(
        &self,
        failed: &[(&Summary, Vec<ScriptedFault>)],
        fails: impl Fn(&Summary, &[ScriptedFault]) -> bool + Sync,
    ) -> Result<Vec<Shrunk>, Failure> {
        let one = |number: usize| {
            let (before, all) = &failed[number];
            let seed = before.seed;
            if number >= MOST {
                return Ok(self.shrunk(seed, all, all, None));
            }
            let kept = fewest(all, |fewer| {
                // Whoever asks to end gets what is known so far.
                if self.is_over() {
                    return Ok(false);
                }
                let run = recorded(&self.with(fewer), self.plans, seed, true)?;
                Ok(fails(&run.summary, fewer) && fails_alike(&run.summary, before))
            })?;
            let report = self.report(seed, &kept)?;
            Ok(self.shrunk(seed, &kept, all, report))
        };
        // Each failed run gets its command, also when the campaign is to end.
        run_all(
            failed.len(),
            self.jobs,
            &AtomicBool::new(false),
            one,
            |_, _| {},
        )
    }

    fn is_over(&self) -> bool {
        self.asked_to_end.load(Ordering::Relaxed)
    }

    /// The scenario with these faults, and no others.
    fn with(&self, faults: &[ScriptedFault]) -> Scenario {
        let mut scenario = self.scenario.clone();
        scenario.faults = faults.to_vec();
        scenario
    }

    fn report(&self, seed: u64, faults: &[ScriptedFault]) -> Result<Option<PathBuf>, Failure> {
        if self.is_over() {
            return Ok(None);
        }
        let mut record = recorded(&self.with(faults), self.plans, seed, true)?;
        record.summary.scenario.push_str(" (stepped)");
        let folder = self.out.join(format!("seed-{seed}"));
        make_folder(&folder)?;
        leave(&folder, &record)?;
        Ok(Some(folder.join("report.html")))
    }

    fn shrunk(
        &self,
        seed: u64,
        kept: &[ScriptedFault],
        all: &[ScriptedFault],
        report: Option<PathBuf>,
    ) -> Shrunk {
        Shrunk {
            command: self.again.command(seed, kept),
            faults: kept.len(),
            of_faults: all.len(),
            report,
        }
    }
}

impl Shrunk {
    /// Prints the command, and where the report is.
    pub fn print(&self) {
        if self.faults < self.of_faults {
            onboard::say!("    with {} of {} faults:", self.faults, self.of_faults);
        }
        onboard::say!("    {}", self.command);
        if let Some(report) = &self.report {
            onboard::say!("    report: {}", report.display());
        }
    }
}

/// A run fails by a violation that another one had, too, or both have none and end alike.
fn fails_alike(run: &Summary, before: &Summary) -> bool {
    let has = |kind: ViolationKind| before.violations.iter().any(|own| own.kind == kind);
    let any = run.violations.iter().any(|own| has(own.kind));
    let ends_alike = (&run.outcome, &run.stranded_by) == (&before.outcome, &before.stranded_by);
    let none = run.violations.is_empty() && before.violations.is_empty();
    any || none && ends_alike
}

/// The fewest of these with which it still fails: without any one of them it does not. With all of them it `fails`, which is not
/// asked.
///
/// # Errors
/// Those of `fails`.
fn fewest<T: Clone>(
    all: &[T],
    mut fails: impl FnMut(&[T]) -> Result<bool, Failure>,
) -> Result<Vec<T>, Failure> {
    let mut kept = all.to_vec();
    loop {
        let (before, mut next) = (kept.len(), 0);
        while next < kept.len() {
            let mut fewer = kept.clone();
            fewer.remove(next);
            if fails(&fewer)? {
                kept = fewer;
            } else {
                next += 1;
            }
        }
        // One that was needed beside others may not be without them.
        if kept.len() == before || kept.is_empty() {
            return Ok(kept);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::summary::Violation;

    /// What is left of the numbers up to 6, and how many times was asked.
    fn left(fails: impl Fn(&[u32]) -> bool) -> (Vec<u32>, usize) {
        let mut asked = 0;
        let all: Vec<u32> = (0..7).collect();
        let kept = fewest(&all, |fewer| {
            asked += 1;
            Ok(fails(fewer))
        });
        (kept.unwrap_or_else(|failure| panic!("{failure:?}")), asked)
    }

    #[test]
    fn what_is_not_needed_is_left_out() {
        let has = |some: &[u32], wanted: &[u32]| wanted.iter().all(|one| some.contains(one));
        assert_eq!(left(|some| has(some, &[4])).0, [4]);
        assert_eq!(left(|some| has(some, &[1, 5])).0, [1, 5]);
        assert_eq!(left(|_| true), (vec![], 7));
        assert_eq!(left(|_| false), ((0..7).collect(), 7));
        // Number 0 can be missed only once 6 is gone.
        let hides = |some: &[u32]| has(some, &[3]) && (has(some, &[0]) || !has(some, &[6]));
        assert_eq!(left(hides).0, [3]);
        let refused = fewest(&[1, 2], |_| Err(Failure::refused("on purpose")));
        assert!(refused.is_err());
    }

    #[test]
    fn a_run_that_fails_otherwise_is_another_one() {
        let run = |kinds: &[ViolationKind]| Summary {
            violations: { kinds.iter() }
                .map(|&kind| Violation {
                    kind,
                    robot: "amr-1".to_owned(),
                    at_s: 1.0,
                    detail: String::new(),
                })
                .collect(),
            ..Summary::default()
        };
        let (none, both) = (
            run(&[]),
            run(&[ViolationKind::Collision, ViolationKind::Lease]),
        );
        let lease = run(&[ViolationKind::Lease]);
        assert!(fails_alike(&lease, &both) && fails_alike(&none, &none));
        assert!(!fails_alike(&none, &lease) && !fails_alike(&lease, &none));
        assert!(!fails_alike(&run(&[ViolationKind::Collision]), &lease));
        let mut stranded = none.clone();
        stranded.outcome = "stranded".to_owned();
        assert!(!fails_alike(&none, &stranded) && fails_alike(&stranded, &stranded));
    }

    #[test]
    fn a_command_says_all_that_makes_the_run() {
        let fault: ScriptedFault = toml::from_str(
            "at_s = 20.0\nfor_s = 0.125\nwhat = \"lose\"\nrobot = \"amr-1\"\nshare = 0.3",
        )
        .expect("a fault");
        let mut again = Again {
            scenario: "my scenarios/it's.toml".into(),
            arguments: ["--rounds", "2", "--set", "fleet.connect=[\"a\"]"]
                .map(str::to_owned)
                .to_vec(),
            has_faults: true,
        };
        assert_eq!(
            again.command(7, &[fault]),
            "rig scenario 'my scenarios/it'\\''s.toml' --rounds 2 --set 'fleet.connect=[\"a\"]' --stepped --seed 7 \
             --without-faults --fault '{ at_s = 20.0, for_s = 0.125, what = \"lose\", robot = \"amr-1\", share = 0.3 }'"
        );
        (again.scenario, again.has_faults) = ("lap".into(), false);
        again.arguments.clear();
        assert_eq!(again.command(1, &[]), "rig scenario lap --stepped --seed 1");
    }
}
