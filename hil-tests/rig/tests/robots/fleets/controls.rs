//! What makes a scenario succeed is taken away.

use rig::run::Ending;

use crate::fleets::bench::{Bench, Without, shipped};
use crate::late::once_more_if_late;

#[test]
fn without_the_mediator_all_stand_before_their_first_border() {
    once_more_if_late(|| {
        let mut scenario = shipped("overtaking");
        scenario.standstill_s = 10.0;
        let mut bench = Bench::start(scenario, Without::Mediator);
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
    });
}

#[test]
fn without_nets_nobody_overtakes() {
    once_more_if_late(|| {
        let mut scenario = shipped("overtaking");
        // With its net the slower robot stands in the lay-by by then.
        scenario.patience_s = 50.0;
        let mut bench = Bench::start(scenario, Without::Nets);
        assert_eq!(bench.until_end(), Ending::TooSlow);
        let (result, summary) = bench.finish(&Ending::TooSlow);
        assert!(result.is_err());
        let outcome = summary["outcome"].as_str().unwrap_or_default();
        assert!(
            outcome.contains("coordination overtaking has run to its end 0 of 1"),
            "{outcome}"
        );
        assert_eq!(summary["violations"], serde_json::json!([]), "{summary}");
        assert_eq!(summary["coordinations"], serde_json::json!([]));
        // The mediator still grants areas: both drive on, one behind the other.
        assert!(summary["grants"]["count"].as_u64() > Some(3), "{summary}");
        let lay_by = { summary["areas"].as_array().into_iter().flatten() }
            .find(|area| area["id"] == "5")
            .expect("the lay-by");
        assert_eq!(lay_by["owners"], serde_json::json!([]), "{summary}");
    });
}
