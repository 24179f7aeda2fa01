//! Fleets on the simulated clock: mediator, robots and the network between them, and controls that must fail.

use rig::run::Ending;
use rig::scenario::Scenario;

use crate::stepped::{ended, json, plans, without_faults};

fn scenario(name: &str) -> Scenario {
    crate::stepped::scenario(name).with_at_most(1)
}

#[test]
fn every_scenario_with_a_mediator_comes_to_its_end() {
    for name in ["overtaking", "docking", "t-junction"] {
        let scenario = scenario(name);
        let summary = without_faults(&scenario, 3);
        assert!(summary.passed(), "{name}: {summary:?}");
        assert!(summary.grants.count > 3, "{name}: {summary:?}");
        for robot in &summary.robots {
            assert_eq!(robot.laps, robot.wanted, "{name}: {robot:?}");
        }
    }
}

#[test]
fn the_same_seed_gives_the_same_run() {
    let scenario = scenario("overtaking");
    let plans = plans(&scenario);
    let [again, other] = [3, 8].map(|seed| ended(&scenario, &plans, seed).1);
    assert_eq!(json(&without_faults(&scenario, 3)), json(&again));
    assert_ne!(json(&other), json(&again));
}

#[test]
fn without_the_mediator_all_stand_before_their_first_border() {
    let mut scenario = scenario("overtaking");
    scenario.standstill_s = 10.0;
    let (ending, summary) = ended(&scenario, &plans(&scenario).without_mediator(), 5);
    assert_eq!(ending, Ending::Standstill);
    // A failed run is not a violation: nobody did what must not be done.
    assert_eq!((summary.violations.len(), summary.grants.count), (0, 0));
    assert!(summary.outcome.starts_with("not complete"), "{summary:?}");
    assert!(summary.mediator.is_none(), "{summary:?}");
    for robot in &summary.robots {
        assert_eq!(robot.laps, 0, "{robot:?}");
        assert!(robot.distance_m < 5.0, "still in its first area: {robot:?}");
    }
}

#[test]
fn without_nets_nobody_overtakes() {
    let mut scenario = scenario("overtaking");
    scenario.patience_s = 60.0;
    let (ending, summary) = ended(&scenario, &plans(&scenario).without_nets(), 5);
    assert_eq!(ending, Ending::TooSlow);
    assert!(summary.coordinations.is_empty() && summary.violations.is_empty());
    let never = "coordination overtaking has run to its end 0 of 1";
    assert!(summary.outcome.contains(never), "{summary:?}");
    // The mediator still grants areas: both drive on, one behind the other.
    assert!(summary.grants.count > 3);
    let lay_by = summary.areas.iter().find(|area| area.id == "5");
    assert!(lay_by.expect("the lay-by").owners.is_empty(), "{summary:?}");
}
