//! A few trials, and controls that must fail.

use std::sync::atomic::AtomicBool;

use rig::campaign::stepped::summary;
use rig::run::{Run, look_on, record};
use rig::scenario::{Changes, Scenario, ScriptedFault, load};
use rig::stepped::Stepped;
use rig::summary::Summary;
use rig::violation::ViolationKind;

use crate::stepped::{plans, shipped};

/// The summary of one run; a robot that does not heed leave is a control.
fn trial(scenario: &Scenario, seed: u64, heeds_leave: bool) -> Summary {
    summary(scenario, &plans(scenario), seed, heeds_leave)
        .unwrap_or_else(|failure| panic!("{failure:?}"))
}

fn scenario(name: &str, patience_s: f64) -> Scenario {
    let mut scenario = crate::stepped::scenario(name);
    scenario.patience_s = patience_s;
    scenario
}

#[test]
fn a_robot_drives_the_whole_course_within_its_leave() {
    let outcome = trial(&scenario("course", 600.0), 11, true);
    assert!(outcome.passed(), "{}", outcome.reason());
    let robot = &outcome.robots[0];
    let figures = robot.figures.as_ref().expect("it was looked at");
    assert!(figures.skills.len() >= 12, "{:?}", figures.skills);
    let [dock_error_m] = figures.dock_errors_m[..] else {
        panic!("it docks once: {:?}", figures.dock_errors_m)
    };
    assert!(dock_error_m.abs() <= 0.02, "{dock_error_m} m");
    assert!(
        robot.withheld > 0 && figures.min_border_m > 0.0,
        "{outcome:?}"
    );
    assert!(figures.min_clearance_m > 0.1 && figures.distance_m > 45.0);
}

/// Two weeks: by then encoders of 32 bits count in steps of a radian.
#[test]
fn a_robot_that_has_driven_for_two_weeks_drives_as_well_as_a_new_one() {
    let [new, old] = [0.0, 14.0 * 24.0].map(|driven_h| {
        let mut lap = scenario("lap", 150.0);
        lap.robots[0].driven_h = driven_h;
        lap.robots[0].goal = rig::scenario::Goal::Laps(1);
        let outcome = trial(&lap, 5, true);
        assert!(outcome.passed(), "{driven_h} h: {}", outcome.reason());
        let robot = &outcome.robots[0];
        (robot.max_lateral_error_m, robot.faults.clone())
    });
    assert!(old.0 < new.0 + 0.01, "{new:?}, {old:?}");
    assert_eq!(new.1, old.1, "faults");
}

#[test]
fn neither_late_threads_nor_lost_frames_turn_what_a_robot_believes() {
    let mut course = scenario("course", 600.0);
    let lasting = |what: &str| {
        let fault = format!("at_s = 0.0, for_s = 600.0, robot = \"amr-1\", {what}");
        toml::from_str::<ScriptedFault>(&fault.replace(", ", "\n")).expect("a fault")
    };
    course.faults = vec![
        lasting("what = \"late-threads\", share = 0.05, by_s = 0.03"),
        lasting("what = \"lose-frames\", share = 0.1"),
    ];
    let outcome = trial(&course, 3, true);
    assert!(outcome.passed(), "{}", outcome.reason());
    let robot = &outcome.robots[0];
    assert!(robot.ethercat.lost_frames > 1000, "{outcome:?}");
    let figures = robot.figures.as_ref().expect("it was looked at");
    // A pose with the stamp of another time was 2 degrees off while the robot turned. One that is never off was not judged.
    let heading_deg = figures.max_heading_error_rad.to_degrees();
    assert!((0.01..0.8).contains(&heading_deg), "{outcome:?}");
}

#[test]
fn a_big_robot_docks_turns_and_leaves_without_a_pause() {
    let changes = Changes {
        robot: Some(shipped("robots/amr-big.toml")),
        site: Some(shipped("sites/docking.toml")),
        set: Vec::new(),
    };
    let round = load(&shipped("scenarios/course.toml"), &changes);
    let mut round = round.unwrap_or_else(|failure| panic!("{failure:?}"));
    round.patience_s = 200.0;
    let outcome = trial(&round, 3, true);
    assert!(outcome.passed(), "{}", outcome.reason());
    let faults = &outcome.robots[0].faults;
    let paused = { faults.iter() }.any(|(fault, _)| fault == "no-free-tube");
    assert!(!paused, "{faults:?}");
}

#[test]
fn a_robot_that_heeds_no_leave_is_found_out() {
    let outcome = trial(&scenario("course", 100.0), 11, false);
    let borders = outcome
        .violations
        .iter()
        .filter(|violation| violation.kind == ViolationKind::Border);
    assert!(borders.count() > 0, "{outcome:?}");
}

#[test]
fn a_course_that_is_not_finished_is_not_done() {
    let outcome = trial(&scenario("course", 12.0), 11, true);
    assert!(!outcome.is_done() && outcome.outcome.contains("were not reached"));
}

#[test]
fn the_same_seed_gives_the_same_run_and_nothing_that_stands_is_hit() {
    let scenario = scenario("clutter", 120.0);
    let figures = |outcome: &Summary| outcome.robots[0].figures.clone().expect("it was looked at");
    let mut done = 0;
    for seed in 1..=8 {
        let outcome = trial(&scenario, seed, true);
        assert_eq!(figures(&outcome).drove_into, 0, "seed {seed}: {outcome:?}");
        done += u32::from(outcome.is_done());
        if seed <= 2 {
            let again = trial(&scenario, seed, true);
            assert_eq!(figures(&outcome), figures(&again), "seed {seed}");
        }
    }
    assert!(done >= 6, "only {done} of 8 reached the end");
}

#[test]
fn a_robot_before_a_closed_way_stands_and_touches_nothing() {
    // The corridor with a wall across it that nobody can pass.
    let mut scenario = scenario("clutter", 90.0);
    scenario.clutter = None;
    let plans = plans(&scenario);
    let stepped = Stepped::new(&scenario, &plans, 5, true, false);
    let stepped = stepped.unwrap_or_else(|failure| panic!("{failure:?}"));
    let wall = sim::world::Obstacle::wall([5.0, -1.6], [5.0, 1.6]);
    stepped.world.lock().add_obstacle(wall).expect("added");
    let mut run = Run::new(scenario, stepped, 5);
    let ending = look_on(&mut run, true, &AtomicBool::new(false)).expect("it runs");
    run.stop();
    let outcome = record(&run, &ending).summary;
    assert!(
        !outcome.is_done() && outcome.violations.is_empty(),
        "{outcome:?}"
    );
    let figures = outcome.robots[0]
        .figures
        .as_ref()
        .expect("it was looked at");
    assert!(figures.min_clearance_m > 0.02, "{outcome:?}");
    assert!(figures.longest_stand_s > 10.0, "{outcome:?}");
}

#[test]
fn a_robot_that_loses_its_bus_on_the_way_to_a_pose_has_not_stopped_there() {
    // On the lane where its operator asks for a stop.
    let start = "robots.amr-1.start={ x_m = 4.8, y_m = 0.5, theta_rad = 3.141592653589793 }";
    let state = "robots.amr-1.start_state=\"drive-6\"";
    let changes = Changes {
        set: vec![start.to_owned(), state.to_owned()],
        ..Changes::default()
    };
    let course = load(&shipped("scenarios/course.toml"), &changes);
    let mut course = course.unwrap_or_else(|failure| panic!("{failure:?}"));
    course.patience_s = 10.0;
    let mut stops = |faults: Vec<ScriptedFault>| {
        course.faults = faults;
        let outcome = trial(&course, 3, true);
        let mut violations = outcome.violations.iter();
        assert!(
            violations.all(|own| own.kind != ViolationKind::StopPose),
            "{outcome:?}"
        );
        let figures = { outcome.robots[0].figures.clone() }.expect("it was looked at");
        assert_eq!(figures.states[..3], ["drive-6", "stop-6", "drive-6"]);
        figures.pose_stop_errors_m
    };
    let [error_m] = stops(Vec::new())[..] else {
        panic!("it stops once")
    };
    assert!(error_m < 0.05, "{error_m} m");
    // Its operator sends it on because it stands.
    let fault = "at_s = 5.0\nfor_s = 4.0\nwhat = \"cut-power\"\nrobot = \"amr-1\"";
    let lost = toml::from_str(fault).expect("a fault");
    assert_eq!(stops(vec![lost]), Vec::<f64>::new());
}
