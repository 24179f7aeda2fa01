//! A few trials on the simulated clock, and controls that must fail.

use onboard::cli::Files;
use onboard::composition::plan::Plan;
use rig::folder::Folder;
use rig::judge::Rules;
use rig::one_robot::course::Course;
use rig::one_robot::trial::Scenario;
use rig::stand_ins::clutter::Clutter;
use rig::stepped::{Outcome, Setup, run};

fn files(site: &str, set: &[&str]) -> Files {
    let shipped = |file: &str| {
        let config = concat!(env!("CARGO_MANIFEST_DIR"), "/../../config");
        format!("{config}/{file}").into()
    };
    Files {
        robot: shipped("robots/amr-1.toml"),
        site: shipped(site),
        set: set.iter().map(|&one| one.to_owned()).collect(),
    }
}

/// The outcome, and whether the robot heeded withheld leave.
fn trial(files: &Files, scenario: &dyn Scenario, seed: u64, heeds_leave: bool) -> Outcome {
    let plan = Plan::load(files).unwrap_or_else(|failure| panic!("{failure:?}"));
    let folder = Folder::new().unwrap_or_else(|failure| panic!("{failure:?}"));
    let setup = Setup {
        plan: &plan,
        files,
        scenario,
        folder: folder.path(),
        heeds_leave,
    };
    run(&setup, seed, false).unwrap_or_else(|failure| panic!("{failure:?}"))
}

fn course(patience_s: f64) -> Course {
    Course {
        start_state: "beside-1".to_owned(),
        patience_s,
    }
}

fn clutter() -> (Files, Clutter) {
    let set = [
        "areas.1.deviation_limit_m=1.2",
        "areas.2.deviation_limit_m=1.2",
        "tubes.detour_curvature_1_m=4",
    ];
    let scenario = Clutter {
        patience_s: 120.0,
        people_heed_m: 0.0,
    };
    (files("sites/corridor.toml", &set), scenario)
}

#[test]
fn a_robot_drives_the_whole_course_within_its_leave() {
    let files = files("sites/course.toml", &[]);
    let outcome = trial(&files, &course(600.0), 11, true);
    assert!(outcome.passed(), "{}", outcome.reason());
    let figures = &outcome.figures;
    assert!(figures.skills.len() >= 12, "{:?}", figures.skills);
    assert_eq!(figures.dock_errors_m.len(), 1);
    assert!(
        outcome.withheld > 0 && figures.min_border_m > 0.0,
        "{outcome:?}"
    );
    assert!(figures.min_clearance_m > 0.1 && figures.distance_m > 45.0);
}

#[test]
fn a_big_robot_docks_turns_and_leaves_without_a_pause() {
    let big = Files {
        robot: concat!(
            env!("CARGO_MANIFEST_DIR"),
            "/../../config/robots/amr-big.toml"
        )
        .into(),
        ..files("sites/docking.toml", &[])
    };
    let plan = Plan::load(&big).unwrap_or_else(|failure| panic!("{failure:?}"));
    let round = Course {
        start_state: (plan.start.start_state.clone()).unwrap_or_else(|| plan.fsm.initial.clone()),
        patience_s: 200.0,
    };
    let outcome = trial(&big, &round, 3, true);
    assert!(outcome.done && outcome.clean, "{}", outcome.reason());
    let paused = { outcome.faults.iter() }.any(|(fault, _)| fault == "no-free-tube");
    assert!(!paused, "{:?}", outcome.faults);
}

#[test]
fn a_robot_that_heeds_no_leave_is_found_out() {
    let files = files("sites/course.toml", &[]);
    let outcome = trial(&files, &course(100.0), 11, false);
    let borders = outcome
        .violations
        .iter()
        .filter(|violation| violation.kind == "border");
    assert!(borders.count() > 0, "{outcome:?}");
}

#[test]
fn a_course_that_is_not_finished_is_not_done() {
    let files = files("sites/course.toml", &[]);
    let outcome = trial(&files, &course(12.0), 11, true);
    assert!(!outcome.done && outcome.missing.contains("were not reached"));
}

#[test]
fn the_same_seed_gives_the_same_run_and_nothing_that_stands_is_hit() {
    let (files, scenario) = clutter();
    let mut done = 0;
    for seed in 1..=8 {
        let outcome = trial(&files, &scenario, seed, true);
        assert_eq!(outcome.figures.drove_into, 0, "seed {seed}: {outcome:?}");
        done += u32::from(outcome.done);
        if seed <= 2 {
            let again = trial(&files, &scenario, seed, true);
            assert_eq!(outcome.figures, again.figures, "seed {seed}");
        }
    }
    assert!(done >= 6, "only {done} of 8 reached the end");
}

/// The corridor with a wall across it that nobody can pass.
struct Closed(Clutter);

impl Scenario for Closed {
    fn name(&self) -> &'static str {
        "closed"
    }

    fn rules(&self) -> Rules {
        self.0.rules()
    }

    fn furnish(
        &self,
        world: &mut sim::world::World,
        _seed: u64,
    ) -> Result<(), sim::world::WorldError> {
        let wall = sim::world::Obstacle::wall([5.0, -1.6], [5.0, 1.6]);
        world.add_obstacle(wall).map(|_| ())
    }

    fn withholds_leave(&self) -> bool {
        false
    }

    fn patience_s(&self) -> f64 {
        90.0
    }

    fn is_done(
        &self,
        site: &config::SiteConfig,
        fsm: &config::FsmConfig,
        figures: &rig::judge::Figures,
        truth: &sim::world::Truth,
    ) -> bool {
        self.0.is_done(site, fsm, figures, truth)
    }

    fn missing(
        &self,
        site: &config::SiteConfig,
        fsm: &config::FsmConfig,
        figures: &rig::judge::Figures,
    ) -> String {
        self.0.missing(site, fsm, figures)
    }

    fn least_done_share(&self) -> f64 {
        1.0
    }
}

#[test]
fn a_robot_before_a_closed_way_stands_and_touches_nothing() {
    let (files, scenario) = clutter();
    let outcome = trial(&files, &Closed(scenario), 5, true);
    assert!(!outcome.done && outcome.clean, "{outcome:?}");
    assert!(outcome.figures.min_clearance_m > 0.02, "{outcome:?}");
    assert!(outcome.figures.longest_stand_s > 10.0, "{outcome:?}");
}
