//! What makes a scenario succeed is taken away.

use rig::run::Ending;

use crate::fleets::bench::{Bench, shipped};

#[test]
fn without_the_mediator_all_stand_before_their_first_border() {
    let mut scenario = shipped("overtaking");
    scenario.standstill_s = 10.0;
    let mut bench = Bench::start(scenario, false);
    assert_eq!(bench.until_end(), Ending::Standstill);
    let robots = bench.run.scenario.robots.len();
    let inside: Vec<usize> = { 0..robots }
        .map(|robot| bench.run.judge.inside(robot).len())
        .collect();
    assert_eq!(inside, vec![1; robots], "each where it started");
    let (result, summary) = bench.finish(&Ending::Standstill);
    assert!(result.is_err());
    let outcome = summary["outcome"].as_str().unwrap_or_default();
    assert!(outcome.starts_with("not complete"), "{outcome}");
    // A failed run is not a violation: nobody did what must not be done.
    assert_eq!(summary["violations"], serde_json::json!([]), "{summary}");
    assert_eq!(summary["mediator"], serde_json::Value::Null);
    assert_eq!(summary["grants"]["count"], 0);
}
