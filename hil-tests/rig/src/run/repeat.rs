//! A run of the real programs that a stall of the machine spoiled is made once more; what it left is kept.

use std::fs;
use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};

use onboard::cli::Failure;

use crate::output::make_folder;
use crate::stalls::{LATCHES, LATCHES_WITHIN_NS, Stalls, VIOLATES_WITHIN_NS};
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
    let spoiled = spoiled_by(&summary).filter(|_| success.is_err());
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

/// The stalls that may be to blame for what went wrong; none: the run passed, no stall was long enough, or something happened for which
/// nothing is an excuse, such as a collision or a latch that lateness cannot cause. What went wrong at a time of its own, violations and
/// latches, must have come soon after a stall; for goals that were not reached one at any time will do.
fn spoiled_by(summary: &Summary) -> Option<Stalls> {
    let stalls = summary.stalls.filter(Stalls::spoil)?;
    let near = |at_s: f64, within_ns: u64| {
        let mut long = summary.long_stalls.iter();
        long.any(|stall| stall.is_near(at_s, within_ns))
    };
    let since_s = summary.stranded_since_s;
    let latched_late = summary.stranded_by.as_deref().is_none_or(|latch| {
        LATCHES.into_iter().any(|own| own.name() == latch)
            && since_s.is_some_and(|since_s| near(since_s, LATCHES_WITHIN_NS))
    });
    let hit_nothing = summary.robots.iter().all(|robot| robot.collisions == 0);
    let mut violations = summary.violations.iter();
    let braked_late =
        violations.all(|own| own.kind.may_come_of_a_stall() && near(own.at_s, VIOLATES_WITHIN_NS));
    let excused = !summary.passed() && latched_late && hit_nothing && braked_late;
    excused.then_some(stalls)
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
    use crate::stalls::LongStall;
    use crate::summary::{DONE, RobotSummary, Violation};
    use crate::violation::ViolationKind;

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
                ..Stalls::default()
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

    /// A run with these violations at 100 s, and a long stall so long before.
    fn stalled(kinds: &[ViolationKind], before_s: f64) -> Summary {
        let to_s = 100.0 - before_s;
        Summary {
            outcome: DONE.to_owned(),
            stalls: Some(Stalls {
                count: 1,
                longest_ms: 31.0,
                ..Stalls::default()
            }),
            long_stalls: vec![LongStall {
                from_s: to_s - 0.031,
                to_s,
            }],
            violations: { kinds.iter() }
                .map(|&kind| Violation {
                    kind,
                    robot: "amr-1".to_owned(),
                    at_s: 100.0,
                    detail: String::new(),
                })
                .collect(),
            ..Summary::default()
        }
    }

    #[test]
    fn a_stall_excuses_what_late_threads_cost_and_nothing_else() {
        let of = |kinds: &[ViolationKind]| stalled(kinds, 1.0);
        let spoiled = |kinds: &[ViolationKind]| spoiled_by(&of(kinds)).is_some();
        assert!(!spoiled(&[]), "it passed");
        assert!(spoiled(&[ViolationKind::Clearance, ViolationKind::Heading]));
        assert!(!spoiled(&[
            ViolationKind::Heading,
            ViolationKind::TwoOwners
        ]));
        for kind in [ViolationKind::EntryWithoutGrant, ViolationKind::RobotEnd] {
            assert!(!spoiled(&[kind]), "{kind}");
        }
        let stuck = Summary {
            outcome: "not complete".to_owned(),
            ..of(&[])
        };
        assert!(spoiled_by(&stuck).is_some());
        for (latch, expected) in [("overruns", true), ("motors-off", false), ("panic", false)] {
            let stranded = Summary {
                stranded_by: Some(latch.to_owned()),
                stranded_since_s: Some(100.0),
                ..stuck.clone()
            };
            assert_eq!(spoiled_by(&stranded).is_some(), expected, "{latch}");
        }
    }

    #[test]
    fn a_stall_excuses_only_what_came_soon_after_it() {
        for (before_s, violation, latch) in [
            (-1.0, false, false),
            (-0.01, true, true),
            (1.9, true, true),
            (4.9, true, false),
            (5.1, false, false),
            (90.0, false, false),
        ] {
            let violated = stalled(&[ViolationKind::Clearance], before_s);
            assert_eq!(spoiled_by(&violated).is_some(), violation, "{before_s} s");
            let stuck = Summary {
                outcome: "not complete".to_owned(),
                ..stalled(&[], before_s)
            };
            assert!(spoiled_by(&stuck).is_some(), "at no time of its own");
            let latched = Summary {
                stranded_by: Some("overruns".to_owned()),
                stranded_since_s: Some(100.0),
                ..stuck
            };
            assert_eq!(spoiled_by(&latched).is_some(), latch, "{before_s} s");
        }
        // Each violation needs a stall of its own.
        let mut both = stalled(&[ViolationKind::Clearance; 2], 1.0);
        both.violations[1].at_s = 200.0;
        assert!(spoiled_by(&both).is_none());
    }
}
