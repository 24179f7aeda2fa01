//! The mediator or a robot is killed, or hangs.

use std::time::Duration;

use onboard::process::runtime::Runtime;
use rig::process::mediator::MediatorProcess;
use rig::run::Ending;
use rustix::process::{Pid, Signal, kill_process};
use serde_json::Value as Json;

use crate::programs::figures::{
    LATE_BESIDE_OTHERS_US, ThreadFigures, all_are_punctual, all_keep_their_time,
};
use crate::programs::fleet::{Bench, Run, has, overtaking, waits};
use crate::programs::late::once_more_if_late;

const START: Duration = Duration::from_secs(30);

/// The emergency robot is on its way through area 1, and the other one is held.
fn passes(run: &Run) -> bool {
    is_held(run) && run.judge.inside(1) == ["1"]
}

/// A coordination has the discrete control of the normal robot.
fn is_held(run: &Run) -> bool {
    let observations = run.stage.listener.observations();
    let mut controlled = observations.controlled().iter();
    controlled.any(|own| own.robot == "amr-1" && own.to_ns.is_none())
}

/// The normal robot gets out of the way, as it was told to. Had it not heard that yet, it would go on beyond the lay-by while
/// nobody tells it anything.
fn gets_out_of_the_way(run: &Run) -> bool {
    let pulls_over = {
        let observations = run.stage.listener.observations();
        let said = observations.said("amr-1");
        said.is_some_and(|said| said.state.fsm_state == "pull-over")
    };
    pulls_over && is_held(run)
}

#[test]
#[ignore = "CI makes these runs"]
fn overtaking_succeeds_though_the_mediator_is_killed_and_comes_back() {
    once_more_if_late(|| {
        let mut bench = Bench::start(overtaking());
        let patience = Duration::from_secs(90);
        bench.until("one gets out of the way", patience, gets_out_of_the_way);
        bench.run.kill_mediator();
        bench.holds_for("robots go on", Duration::from_secs(2), |run| {
            run.judge.violations().is_empty()
        });
        restart(&mut bench);
        bench.until("the other one passes", Duration::from_secs(90), passes);
        // In the most delicate moment once more.
        bench.run.kill_mediator();
        restart(&mut bench);
        let ending = bench.until_end();
        let (result, summary, page) = bench.finish(&ending);
        assert_eq!(ending, Ending::Done, "{summary:#}");
        assert!(result.is_ok(), "{result:?}");
        assert_eq!(summary["mediator"]["starts"], 3);
        says_how_it_went(&summary);
        assert!(page.contains("<svg"));
    });
}

/// All goals are reached, nothing is violated, and everything that is to be measured was.
fn says_how_it_went(summary: &Json) {
    assert_eq!(summary["outcome"], "done");
    assert_eq!(summary["violations"], serde_json::json!([]), "{summary:#}");
    let count = |list: &Json| list.as_array().map_or(0, Vec::len);
    assert_eq!(count(&summary["robots"]), 2);
    for robot in summary["robots"].as_array().into_iter().flatten() {
        assert_eq!(robot["laps"], robot["wanted"], "{robot}");
        assert_eq!(robot["collisions"], 0, "{robot}");
        assert!(robot["threads"]["fieldbus"]["cycles"].as_u64() > Some(1000));
    }
    // The net has run to its end, in this order at least.
    let coordination = &summary["coordinations"][0];
    assert_eq!(coordination["net"], "overtaking");
    let firings = coordination["firings"].as_array().into_iter().flatten();
    let firings: Vec<&str> = { firings }
        .filter_map(|own| own["transition"].as_str())
        .collect();
    let at = |name: &str| firings.iter().position(|own| *own == name);
    assert!(
        at("aside") < at("pass") && at("pass") < at("back"),
        "{firings:?}"
    );
    assert!(at("aside").is_some(), "{firings:?}");
    assert!(summary["during"][0]["checked_s"].as_f64() > Some(1.0));
    assert_eq!(summary["during"][0]["broken_s"].as_f64(), Some(0.0));
    assert!(summary["grants"]["count"].as_u64() > Some(3));
    assert!(summary["commands"]["count"].as_u64() > Some(2));
    let area = &summary["areas"][0];
    assert!(count(&area["owners"]) >= 2, "{area}");
}

/// Overtaking, where both robots have the area in which they stand.
fn both_where_they_begin() -> Bench {
    let mut bench = Bench::start(overtaking());
    bench.until("both have where they stand", START, |run| {
        has(run, "amr-1", "6") && has(run, "amr-2", "4")
    });
    bench
}

fn restart(bench: &mut Bench) {
    let started = bench.run.start_mediator_again();
    assert!(started.is_ok(), "{started:?}");
}

#[test]
fn the_areas_of_a_robot_that_is_killed_stay_blocked_until_an_operator_clears_them() {
    once_more_if_late(|| {
        let mut bench = both_where_they_begin();
        // The emergency robot is behind the other one, and wants to go where that is.
        bench.run.kill_robot(0);
        bench.until("amr-2 asks for area 6", START, |run| {
            waits(run, "amr-2", "6")
        });
        bench.holds_for("nobody gets area 6", Duration::from_secs(3), |run| {
            !has(run, "amr-2", "6")
        });
        let said = bench.run.clear("6", &["amr-1"]);
        assert!(
            said.as_ref().is_ok_and(|said| said.contains("amr-1")),
            "{said:?}"
        );
        bench.until("amr-2 gets area 6", Duration::from_secs(5), |run| {
            has(run, "amr-2", "6")
        });
        let (result, summary, _) = bench.finish(&Ending::Interrupted);
        assert!(result.is_err(), "it was not done");
        let violations = summary["violations"].as_array().expect("a list");
        assert!(violations.is_empty(), "{violations:?}");
    });
}

#[test]
fn a_mediator_that_hangs_costs_no_robot_its_time() {
    once_more_if_late(|| {
        let mut bench = both_where_they_begin();
        let robots = ["amr-1", "amr-2"];
        let runtime = Runtime::new(Some(bench.run.stage.folder().join("run"))).expect("a folder");
        let threads = || robots.map(|robot| ThreadFigures::of(&runtime, robot));
        let before = threads();
        signal_mediator(&bench.run, Signal::STOP);
        bench.until("both hear nothing", START, |run| {
            robots.iter().all(|robot| hears_nothing(run, robot))
        });
        // They go as far as they may, and no farther.
        bench.holds_for(
            "nobody enters what is not its own",
            Duration::from_secs(8),
            |run| run.judge.violations().is_empty(),
        );
        for (before, after) in before.iter().zip(&threads()) {
            all_keep_their_time(before, after);
            all_are_punctual(before, after, LATE_BESIDE_OTHERS_US);
        }
        signal_mediator(&bench.run, Signal::CONT);
        bench.until("both hear it again", START, |run| {
            !robots.iter().any(|robot| hears_nothing(run, robot))
        });
        let (_, summary, _) = bench.finish(&Ending::Interrupted);
        assert_eq!(summary["violations"], serde_json::json!([]), "{summary:#}");
    });
}

fn signal_mediator(run: &Run, signal: Signal) {
    let mediator = run.stage.mediator.as_ref().and_then(MediatorProcess::id);
    let mediator = mediator.and_then(|id| Pid::from_raw(id.cast_signed()));
    kill_process(mediator.expect("it runs"), signal).expect("ours");
}

fn hears_nothing(run: &Run, robot: &str) -> bool {
    let observations = run.stage.listener.observations();
    observations.said(robot).is_some_and(|said| {
        let mut faults = said.state.faults.iter();
        faults.any(|fault| fault.name == "mediator-silent" && fault.active)
    })
}
