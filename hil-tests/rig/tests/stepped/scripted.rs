//! Faults that are scripted and never drawn, because no fleet comes through them yet.
//!
//! Each test says what happens today, and that it does not happen without the fault. Where that is unsafe, the judge sees it: fault
//! and judge do their work. To be turned round when the fleet comes through.

use rig::scenario::{Scenario, ScriptedFault};
use rig::summary::Summary;
use rig::violation::ViolationKind;

use crate::{ended, plans};

/// One run with this fault, and one without.
fn with_and_without(mut scenario: Scenario, fault: &str, seed: u64) -> [Summary; 2] {
    let fault: ScriptedFault = toml::from_str(&fault.replace("; ", "\n")).expect("a fault");
    let plans = plans(&scenario);
    let without = ended(&scenario, &plans, seed).1;
    scenario.faults = vec![fault];
    [ended(&scenario, &plans, seed).1, without]
}

fn found(summary: &Summary, kind: ViolationKind, robot: &str) -> bool {
    { summary.violations.iter() }.any(|own| own.kind == kind && own.robot == robot)
}

fn two_owners(summary: &Summary) -> bool {
    { summary.violations.iter() }.any(|own| own.kind == ViolationKind::TwoOwners)
}

/// Three robots that meet, for a while.
fn junction() -> Scenario {
    let mut scenario = crate::scenario("t-junction");
    scenario.patience_s = 20.0;
    scenario
}

#[test]
fn a_mediator_without_its_journal_grants_areas_that_robots_have() {
    let fault = "at_s = 10.0; for_s = 6.0; what = \"lose-journal\"";
    let [with, without] = with_and_without(junction(), fault, 1);
    assert_eq!(without.violations, []);
    assert!(two_owners(&with), "{with:?}");
    let together = found(&with, ViolationKind::OverCapacity, "amr-1");
    assert!(together, "{with:?}");
}

#[test]
fn a_second_mediator_grants_areas_that_robots_have() {
    let fault = "at_s = 10.0; for_s = 6.0; what = \"second-mediator\"";
    let [with, without] = with_and_without(junction(), fault, 1);
    assert_eq!(without.violations, []);
    assert!(two_owners(&with), "{with:?}");
}

#[test]
fn a_mediator_with_an_older_journal_hinders_the_overtaking_that_it_forgot() {
    let mut scenario = crate::scenario("overtaking");
    scenario.patience_s = 80.0;
    let fault = "at_s = 24.0; for_s = 4.0; what = \"restore-journal\"";
    let [with, without] = with_and_without(scenario, fault, 3);
    assert!(without.passed(), "{without:?}");
    // Safe, and of no use: until it is broken off, both robots wait for each other.
    assert!(!with.is_done() && with.violations.is_empty(), "{with:?}");
    assert_eq!(with.mediator.expect("a mediator").starts, 2);
    let lasted_s = |summary: &Summary| summary.coordinations[0].duration_s;
    assert!(lasted_s(&without).is_some_and(|lasted_s| lasted_s < 50.0));
    assert_eq!(lasted_s(&with), None, "{with:?}");
}

#[test]
fn a_robot_whose_clone_has_registered_is_heard_no_more() {
    let mut scenario = crate::scenario("overtaking");
    scenario.standstill_s = 20.0;
    let fault = "at_s = 24.0; for_s = 4.0; what = \"clone-robot\"; robot = \"amr-1\"";
    let [with, without] = with_and_without(scenario, fault, 3);
    assert!(without.passed(), "{without:?}");
    let silent = |summary: &Summary| {
        let mut faults = summary.robots[0].faults.iter();
        faults.any(|(fault, _)| fault == "mediator-silent")
    };
    // Long after the clone is gone it still stands, and nobody says why.
    assert!(silent(&with) && !silent(&without), "{with:?}");
    assert!(!with.is_done() && with.violations.is_empty(), "{with:?}");
}

#[test]
fn a_clone_on_the_floor_drives_on_the_grants_of_its_robot() {
    let mut scenario = crate::scenario("overtaking");
    scenario.patience_s = 80.0;
    // Where its robot started.
    let fault = "at_s = 40.0; for_s = 45.0; what = \"clone-robot\"; robot = \"amr-1\"; pose = [3.0, 0.5, 180.0]";
    let [with, without] = with_and_without(scenario, fault, 3);
    assert!(without.passed(), "{without:?}");
    let clone = "clone of amr-1";
    let cases = [
        // When the clone registered, the areas of its robot were given up.
        (ViolationKind::EntryWithoutGrant, "amr-1"),
        (ViolationKind::EntryWithoutGrant, clone),
        // Two bodies in one area.
        (ViolationKind::OverCapacity, clone),
        (ViolationKind::OverCapacity, "amr-2"),
    ];
    for (kind, robot) in cases {
        assert!(found(&with, kind, robot), "{kind} of {robot}: {with:?}");
    }
}
