//! A run of the real programs that a stall of the machine spoiled is made once more; what it left is kept.

use std::fs;
use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};

use onboard::cli::Failure;

use crate::output::make_folder;
use crate::summary::{Spoiled, Summary};

/// Folder, in that of the run, for what a spoiled run left.
pub const SPOILED: &str = "spoiled";

/// Makes a run with its results in `out`, and once more if a stall spoiled it. `once` is told of the spoiled run before it; it returns
/// the summary, and the run's success.
///
/// # Errors
/// That of the last run; [`Failure::Failed`] when what a spoiled run left cannot be kept.
pub(super) fn repeated(
    out: &Path,
    asked_to_end: &AtomicBool,
    mut once: impl FnMut(Option<Spoiled>) -> Result<(Summary, Result<(), Failure>), Failure>,
) -> Result<(), Failure> {
    // What an earlier run left must not be taken for this one's.
    let _ = fs::remove_dir_all(out.join(SPOILED));
    let (summary, success) = once(None)?;
    let spoiled = summary.spoiled_by().filter(|_| success.is_err());
    let Some(stalls) = spoiled.filter(|_| !asked_to_end.load(Ordering::Relaxed)) else {
        return success;
    };
    set_aside(out, &summary)?;
    onboard::say!(
        "spoiled: {}{}, and {stalls}; once more. What it left is in {}",
        summary.outcome,
        summary.with_violations(),
        out.join(SPOILED).display()
    );
    let spoiled = Spoiled {
        reason: summary.reason(),
        stalls,
    };
    once(Some(spoiled))?.1
}

/// Moves what a run has left out of the way of the next one.
fn set_aside(out: &Path, summary: &Summary) -> Result<(), Failure> {
    let folder = out.join(SPOILED);
    make_folder(&folder)?;
    let logs = { summary.robots.iter() }.map(|robot| format!("{}.log", robot.id));
    let names = ["summary.json", "report.html", "report.svg", "mediator.log"];
    for name in { names.into_iter() }.map(str::to_owned).chain(logs) {
        if out.join(&name).is_file() {
            fs::rename(out.join(&name), folder.join(&name)).map_err(Failure::failed)?;
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::folder::Folder;
    use crate::output::write;
    use crate::stalls::Stalls;
    use crate::summary::{DONE, RobotSummary};

    /// How a run ended: with this outcome, this longest stall and so many collisions.
    type Came<'a> = (&'a str, f64, u64);

    /// Makes runs that come out like these; returns whether the last one succeeded, and what each was told.
    fn made(
        folder: &Folder,
        asked_to_end: bool,
        came: &[Came<'_>],
    ) -> (bool, Vec<Option<Spoiled>>) {
        let mut told = Vec::new();
        let success = repeated(folder.path(), &AtomicBool::new(asked_to_end), |before| {
            let (outcome, longest_ms, collisions) = came[told.len()];
            told.push(before);
            for name in ["summary.json", "amr-1.log", "rig.log"] {
                write(folder.path(), name, outcome)?;
            }
            let stalls = Stalls {
                count: 1,
                longest_ms,
                steal_ms: 0.0,
            };
            let robot = RobotSummary {
                id: "amr-1".into(),
                collisions,
                ..RobotSummary::default()
            };
            let summary = Summary {
                outcome: outcome.into(),
                stalls: Some(stalls),
                robots: vec![robot],
                ..Summary::default()
            };
            let success = match summary.passed() {
                true => Ok(()),
                false => Err(Failure::failed("on purpose")),
            };
            Ok((summary, success))
        });
        (success.is_ok(), told)
    }

    #[test]
    fn a_spoiled_run_is_made_once_more_and_kept() {
        let folder = Folder::new().expect("a folder");
        let (succeeded, told) = made(&folder, false, &[("stuck", 15.0, 0), (DONE, 0.0, 0)]);
        assert!(succeeded);
        let [None, Some(spoiled)] = &told[..] else {
            panic!("{told:?}");
        };
        assert_eq!(
            (&*spoiled.reason, spoiled.stalls.longest_ms),
            ("stuck", 15.0)
        );
        let text = |name: &str| fs::read_to_string(folder.path().join(name)).unwrap_or_default();
        for (name, kept, last) in [
            ("summary.json", "stuck", DONE),
            ("amr-1.log", "stuck", DONE),
            ("rig.log", "", DONE),
        ] {
            let both = (text(&format!("{SPOILED}/{name}")), text(name));
            assert_eq!(both, (kept.to_owned(), last.to_owned()), "{name}");
        }
        // The next run in this folder has nothing to do with it.
        let (succeeded, told) = made(&folder, false, &[(DONE, 90.0, 0)]);
        assert!(succeeded && told == [None]);
        assert_eq!(text("spoiled/summary.json"), "");
    }

    #[test]
    fn no_other_run_is_made_once_more_and_none_twice() {
        let folder = Folder::new().expect("a folder");
        for (asked_to_end, came, runs) in [
            (false, ("stuck", 14.9, 0), 1),
            (false, ("stuck", 31.0, 1), 1),
            (true, ("interrupted", 31.0, 0), 1),
            (false, ("stuck", 31.0, 0), 2),
        ] {
            let (succeeded, told) = made(&folder, asked_to_end, &[came; 2]);
            assert!(!succeeded && told.len() == runs, "{came:?}: {told:?}");
        }
    }
}
