//! A process that ends at any moment of a manoeuvre: the next one goes on from what it has left.

use crate::closed_loop::docks::docking;
use crate::closed_loop::floor::Floor;
use crate::closed_loop::junctions::crossing;
use crate::closed_loop::robot::Robot;
use crate::random::Random;
use description::geometry::{Pose2, wrap_angle};
use skills::navigator::NavigatorCheckpoint;
use std::f64::consts::PI;

/// No run takes longer.
const LIMIT_S: f64 = 90.0;

/// Ends and begins again every few seconds, until the machine is in the last state and the lane is reached. Returns where it
/// came into each state.
fn crashing(
    floor: &Floor,
    last: &str,
    lane: &str,
    start: Pose2,
    seed: u64,
) -> Vec<(String, Pose2)> {
    let mut came = Vec::new();
    let mut robot = floor.robot(seed, start);
    let mut random = Random::new(seed);
    let mut crashes = 0;
    let mut next_s = random.between(0.5, 3.0);
    let mut driven_s = 0.0;
    while robot.state() != last {
        assert!(driven_s < LIMIT_S, "seed {seed}: {:?}", robot.output);
        let before = robot.state().to_owned();
        robot.run_for(0.01);
        driven_s += 0.01;
        if robot.state() != before {
            came.push((robot.state().to_owned(), robot.plant.pose));
        }
        if driven_s > next_s {
            robot.crash(random.between(0.01, 2.0));
            crashes += 1;
            next_s = driven_s + random.between(0.5, 3.0);
        }
        assert!(
            robot.pose_error_m() < 0.09,
            "seed {seed}: {:?}",
            robot.output
        );
    }
    assert!(crashes >= 5, "{crashes}");
    robot.run_for(4.0);
    check_on(floor, lane, &robot, seed);
    came
}

fn check_on(floor: &Floor, lane: &str, robot: &Robot, seed: u64) {
    let lane = floor.site.lanes.iter().find(|one| one.id == lane);
    let line = lane.expect("a lane").line;
    let truth = robot.plant.pose;
    let off_m = line.lateral_m(truth.position());
    let off_rad = wrap_angle(truth.theta_rad - line.direction_rad());
    assert!(
        off_m.abs() < 0.04 && off_rad.abs() < 0.05,
        "seed {seed}: {off_m} m, {off_rad} rad"
    );
}

#[test]
fn a_dock_a_creep_and_a_u_turn_are_driven_to_their_ends() {
    for seed in 1..=12 {
        let start = Pose2::new(3.0, -0.5, 0.0);
        let came = crashing(&docking(), "home", "out", start, seed);
        let at = |state: &str| {
            let found = came.iter().find(|(name, _)| name == state);
            found.expect("it came there").1
        };
        // Not a way of its own for each crash.
        let crept = at("creep").between(at("turn"));
        assert!((crept.x_m + 0.6).abs() < 0.04, "seed {seed}: {crept:?}");
    }
}

#[test]
fn a_turn_at_a_junction_is_driven_to_its_end() {
    let ways = [
        ("west-in", "south-out", 0.5, Pose2::new(-4.0, -0.5, 0.0)),
        ("east-in", "south-out", 0.9, Pose2::new(4.0, 0.5, PI)),
    ];
    for (from, to, radius_m, start) in ways {
        for seed in 1..=8 {
            crashing(&crossing(from, to, radius_m), "on", to, start, seed);
        }
    }
}

#[test]
fn the_wrong_numbers_are_refused_and_change_nothing() {
    let floor = docking();
    let mut robot = floor.robot(1, Pose2::new(3.0, -0.5, 0.0));
    robot.run_for(2.0);
    let good = robot.navigator.checkpoint();
    let spoils: [fn(&mut NavigatorCheckpoint); 6] = [
        |one| one.state = 99,
        |one| one.uncertain = 1,
        |one| one.pose.x_m = f64::NAN,
        |one| one.began.theta_rad = f64::INFINITY,
        |one| one.covariance[1][1] = 0.0,
        |one| one.covariance[0][1] = f64::NAN,
    ];
    for spoil in spoils {
        let mut bad = good;
        spoil(&mut bad);
        assert!(!robot.navigator.resume(&bad), "{bad:?}");
    }
    let after = robot.navigator.checkpoint();
    assert_eq!(format!("{after:?}"), format!("{good:?}"));
}
