//! Detours keep to the deviation limit, and a robot that strayed comes back when it is reset.

use onboard::process::ctl::Request;
use sim::world::{Pose, Shape, World};

use crate::stepped::bench::Bench;

const LANE_Y_M: f64 = -0.5;
const LIMIT_M: f64 = 0.30;

fn at(world: &World) -> Pose {
    world.truth(0).expect("a robot").pose
}

fn off_m(world: &World) -> f64 {
    (at(world).y_m - LANE_Y_M).abs()
}

const DETOURS: &str = "tubes.detour_curvature_1_m=4";

#[test]
fn before_a_closed_way_it_stays_within_the_deviation_limit() {
    let wall = Shape::Box {
        pose: Pose::new(5.0, 0.0, 0.0),
        length_m: 0.1,
        width_m: 3.2,
    };
    let mut bench = Bench::new(Pose::new(2.0, LANE_Y_M, 0.0), 0.0, &[wall], &[DETOURS]);
    let mut most_off_m: f64 = 0.0;
    let strayed = bench.run(120, |belief, world| {
        most_off_m = most_off_m.max(off_m(world));
        belief.state.starts_with("halt")
    });
    assert!(!strayed && most_off_m < LIMIT_M, "{most_off_m} m off");
    // It has tried, and stands in the end.
    let truth = bench.world.lock().truth(0).expect("a robot");
    assert!(truth.pose.x_m > 3.5 && truth.collisions == 0, "{truth:?}");
    let before = at(&bench.world.lock());
    assert!(!bench.run(20, |_, world| (at(world).x_m - before.x_m).abs() > 0.01));
}

#[test]
fn a_way_around_that_fits_into_the_limit_is_taken() {
    let thing = Shape::Box {
        pose: Pose::new(4.5, -0.72, 0.0),
        length_m: 0.15,
        width_m: 0.15,
    };
    let mut bench = Bench::new(Pose::new(2.0, LANE_Y_M, 0.0), 0.0, &[thing], &[DETOURS]);
    let mut most_off_m: f64 = 0.0;
    let passed = bench.run(60, |belief, world| {
        most_off_m = most_off_m.max(off_m(world));
        assert!(!belief.state.starts_with("halt"), "strayed");
        at(world).x_m > 5.5
    });
    assert!(
        passed && most_off_m < LIMIT_M,
        "{:?}, {most_off_m} m off",
        at(&bench.world.lock())
    );
}

#[test]
fn a_robot_that_strayed_comes_back_when_it_is_reset() {
    // 0.45 m off its lane, more than it was told, and turned away from it.
    let start = Pose::new(2.5, -0.05, 0.7);
    let mut bench = Bench::new(start, 0.16, &[], &[]);
    assert!(
        bench.run(5, |belief, _| belief.state == "halt-1"),
        "strayed"
    );
    assert!(!bench.run(10, |belief, _| belief.state != "halt-1"));
    bench.ask(Request::Reset);
    let mut halted = false;
    let back = bench.run(20, |belief, world| {
        halted |= at(world) != start && belief.state.starts_with("halt");
        off_m(world) < 0.05
    });
    assert!(back && !halted, "{:?}", at(&bench.world.lock()));
    assert!(
        bench.run(20, |belief, _| belief.state == "search-2"),
        "it drives on"
    );
}

#[test]
fn a_strayed_robot_that_cannot_come_back_halts_again() {
    let start = Pose::new(2.5, -0.05, 0.0);
    let across = Shape::Box {
        pose: Pose::new(3.1, -0.05, 0.0),
        length_m: 0.1,
        width_m: 1.0,
    };
    let mut bench = Bench::new(start, 0.16, &[across], &[]);
    assert!(
        bench.run(5, |belief, _| belief.state == "halt-1"),
        "strayed"
    );
    bench.ask(Request::Reset);
    assert!(bench.run(2, |belief, _| belief.state == "drive-1"), "reset");
    assert!(
        !bench.run(10, |belief, _| belief.state != "drive-1"),
        "it waits"
    );
    assert!(
        bench.run(25, |belief, _| belief.state == "halt-1"),
        "not for ever"
    );
}
