//! Left, right and straight on at a junction, until the next corridor is reacquired.

use crate::closed_loop::floor::{Floor, junction};
use description::geometry::{Pose2, wrap_angle};
use description::site::{ControllerConfig, Feature, MonitorKind};
use skills::control::manoeuvre;
use std::f64::consts::{FRAC_PI_2, PI};

const FOLLOW: ControllerConfig = ControllerConfig::Corridor { offset_m: 0.0 };

/// From one arm over the crossing into another.
pub fn crossing(from: &str, to: &str, radius_m: f64) -> Floor {
    junction()
        .reached("at-crossing", [-1.2, -1.2], [1.2, 1.2])
        .monitor("turned", MonitorKind::ManoeuvreDone)
        .monitor(
            "reacquired",
            MonitorKind::EstimateStable {
                feature: Feature::Corridor,
                scans: 5,
                max_std_m: 0.03,
            },
        )
        .state("drive", from, FOLLOW, &["at-crossing"])
        .state("turn", to, ControllerConfig::Turn { radius_m }, &["turned"])
        .at_speed(0.3)
        .state("reacquire", to, FOLLOW, &["reacquired"])
        .at_speed(0.2)
        .state("on", to, FOLLOW, &[])
        .go("drive", "at-crossing", "turn")
        .go("turn", "turned", "reacquire")
        .go("reacquire", "reacquired", "on")
}

fn check(from: &str, to: &str, radius_m: f64, start: Pose2) {
    let floor = crossing(from, to, radius_m);
    let lane = |id: &str| {
        let found = floor.site.lanes.iter().find(|lane| lane.id == id);
        found.expect("a lane").line
    };
    let (incoming, outgoing) = (lane(from), lane(to));
    let from_start = Pose2::new(incoming.a.x_m, incoming.a.y_m, incoming.direction_rad());
    let ideal = manoeuvre::turn(radius_m, 2.5, &incoming, &outgoing, from_start).unwrap();
    for seed in 1..=6 {
        let mut robot = floor.robot(seed, start);
        robot.run_until("turn", 30.0);
        let mut along_m = 0.0;
        let mut worst_m: f64 = 0.0;
        while robot.state() == "turn" {
            robot.run_for(0.01);
            let truth = robot.plant.pose;
            let place = ideal.place(truth, along_m);
            along_m = place.along_m;
            worst_m = worst_m.max(place.error.lateral_m.abs());
            assert!(
                robot.plant.clearance_m() > 0.3,
                "{from} {to} {seed}: {truth:?}"
            );
            assert!(robot.pose_error_m() < 0.05, "{from} {to} {seed}: {truth:?}");
        }
        assert!(worst_m < 0.10, "{from} {to} {seed}: {worst_m}");
        robot.run_until("on", 10.0);
        let output = robot.output.unwrap();
        assert!(output.corridor.unwrap().usable);
        robot.run_for(2.0);
        let truth = robot.plant.pose;
        let off_m = outgoing.lateral_m(truth.position());
        let off_rad = wrap_angle(truth.theta_rad - outgoing.direction_rad());
        assert!(
            off_m.abs() < 0.03 && off_rad.abs() < 0.04,
            "{from} {to} {seed}: {truth:?}"
        );
        let seen_m = robot.output.unwrap().corridor.unwrap().lateral_m;
        assert!((seen_m - off_m).abs() < 0.03, "{seen_m} {off_m}");
        assert_eq!(robot.allocations, 0);
    }
}

#[test]
fn right_from_the_west() {
    check("west-in", "south-out", 0.5, Pose2::new(-4.0, -0.5, 0.0));
}

#[test]
fn right_from_the_south() {
    check(
        "south-in",
        "east-out",
        0.5,
        Pose2::new(0.5, -4.0, FRAC_PI_2),
    );
}

#[test]
fn left_from_the_east() {
    check("east-in", "south-out", 0.9, Pose2::new(4.0, 0.5, PI));
}

#[test]
fn left_from_the_south() {
    check(
        "south-in",
        "west-out",
        0.9,
        Pose2::new(0.5, -4.0, FRAC_PI_2),
    );
}

#[test]
fn straight_on_both_ways() {
    check("west-in", "east-out", 0.5, Pose2::new(-4.0, -0.5, 0.0));
    check("east-in", "west-out", 0.5, Pose2::new(4.0, 0.5, PI));
}
