//! The judge finds what it is there to find: it is told less than what is so, or robots know less than it does.

use rig::scenario::{Scenario, ScriptedFault};
use rig::summary::Summary;
use rig::violation::ViolationKind;

use crate::stepped::{plans, watched};

/// All of it shows by then.
const SHOWS_BY_S: f64 = 30.0;

/// What the judge of one scenario says of the beginning of a run of another one.
fn judged(judge: &Scenario, driven: &Scenario, seed: u64) -> Summary {
    watched(judge, driven, &plans(driven), seed, SHOWS_BY_S)
        .1
        .summary
}

fn kinds(summary: &Summary) -> Vec<ViolationKind> {
    let mut kinds: Vec<_> = summary.violations.iter().map(|own| own.kind).collect();
    kinds.sort_unstable();
    kinds.dedup();
    kinds
}

fn fault(text: &str) -> ScriptedFault {
    toml::from_str(&text.replace("; ", "\n")).expect("a fault")
}

/// Areas hold nobody by what the judge knows.
#[test]
fn robots_in_areas_that_hold_fewer_are_found() {
    let true_one = crate::stepped::scenario("overtaking");
    let mut told = true_one.clone();
    (told.site.areas.iter_mut()).for_each(|area| area.capacity = 0);
    let found = kinds(&judged(&told, &true_one, 3));
    for kind in [ViolationKind::OverCapacity, ViolationKind::TwoOwners] {
        assert!(found.contains(&kind), "{kind:?} is not in {found:?}");
    }
}

/// Areas begin farther out by what the judge knows than by what robots do.
#[test]
fn robots_that_come_in_before_they_have_leave_are_found() {
    let true_one = crate::stepped::scenario("overtaking");
    let mut told = true_one.clone();
    for area in &mut told.site.areas {
        area.region.min.x_m -= 0.6;
        area.region.max.x_m += 0.6;
    }
    let found = kinds(&judged(&told, &true_one, 3));
    let kind = ViolationKind::EntryWithoutGrant;
    assert!(found.contains(&kind), "{kind:?} is not in {found:?}");
}

/// Its motors brake less hard than its file says, and than the judge knows.
#[test]
fn a_robot_that_brakes_too_weakly_is_found() {
    let stop = fault("at_s = 6.0; for_s = 6.0; what = \"stop\"; robot = \"amr-2\"");
    let weak =
        fault("at_s = 5.0; for_s = 8.0; what = \"weak-brakes\"; robot = \"amr-2\"; share = 0.6");
    let mut told = crate::stepped::scenario("overtaking");
    told.faults = vec![stop.clone()];
    assert_eq!(kinds(&judged(&told, &told, 3)), []);
    let mut true_one = told.clone();
    true_one.faults = vec![stop, weak];
    let found = kinds(&judged(&told, &true_one, 3));
    assert_eq!(found, [ViolationKind::UnsafeSpeed]);
}

/// It drives on when it was told to stop.
#[test]
fn a_robot_that_does_not_stop_is_found() {
    let mut told = crate::stepped::scenario("overtaking");
    told.faults = vec![fault(
        "at_s = 6.0; for_s = 6.0; what = \"stop\"; robot = \"amr-2\"",
    )];
    let found = kinds(&judged(&told, &crate::stepped::scenario("overtaking"), 3));
    assert_eq!(found, [ViolationKind::UnsafeSpeed]);
}
