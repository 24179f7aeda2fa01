//! Areas that are not allowed.

use crate::closed_loop::floor::{Floor, corridor, junction};
use crate::closed_loop::robot::Robot;
use crate::closed_loop::stops::{FAR, START, front_x_m};
use description::areas::AreaIndex;
use description::geometry::Pose2;
use description::site::{ControllerConfig, Feature, MonitorKind};
use skills::borders::AreaSet;
use skills::navigator::Hold;

const FOLLOW: ControllerConfig = ControllerConfig::Corridor { offset_m: 0.0 };

fn without(floor: &Floor, areas: &[&str]) -> AreaSet {
    let mut allowed = AreaSet::ALL;
    for id in areas {
        let place = floor.site.areas.iter().position(|area| area.id == *id);
        allowed.remove(place.and_then(AreaIndex::new).expect("an area"));
    }
    allowed
}

#[test]
fn an_area_without_leave_is_waited_for_and_entered_when_allowed() {
    let floor = corridor().state("drive", "2", FOLLOW, &[]);
    for seed in 1..=12 {
        let mut robot = floor.robot(seed, FAR);
        robot.allowed = without(&floor, &["3", "4", "5", "6", "7"]);
        for _ in 0..130 {
            robot.run_for(0.1);
            assert!(front_x_m(&robot) < 8.5, "seed {seed}");
        }
        let output = robot.output.unwrap();
        assert_eq!(
            output.waiting_for,
            AreaIndex::new(2),
            "seed {seed}: {output:?}"
        );
        assert_eq!(
            (output.hold, output.command.speed_m_s),
            (Some(Hold::Border), 0.0)
        );
        assert!(output.border_distance_m.unwrap() < 0.05);
        let left_m = 8.5 - front_x_m(&robot);
        assert!(left_m < 0.07, "seed {seed}: {left_m}");
        robot.allowed = AreaSet::ALL;
        robot.run_for(3.0);
        let output = robot.output.unwrap();
        assert!(
            front_x_m(&robot) > 8.8 && output.waiting_for.is_none(),
            "{output:?}"
        );
        assert_eq!(robot.allocations, 0);
    }
}

/// A lidar whose ranges are all too long, which no scan can tell from a wall that is farther away.
#[test]
fn what_map_and_lidar_may_be_wrong_by_is_kept_from_borders() {
    let floor = corridor().state("drive", "2", FOLLOW, &[]);
    for (map_error_m, enters) in [(0.0, true), (0.05, false)] {
        for seed in 1..=6 {
            let mut setup = floor.setup(FAR);
            setup.gains.map_error_m = map_error_m;
            let mut robot = Robot::around(floor.robot(seed, FAR).plant, setup);
            robot.trouble.too_long_mm = 50;
            robot.allowed = without(&floor, &["3", "4", "5", "6", "7"]);
            robot.run_for(15.0);
            let hold = robot.output.and_then(|output| output.hold);
            assert_eq!(hold, Some(Hold::Border), "seed {seed}");
            let front_m = front_x_m(&robot);
            assert_eq!(front_m > 8.5, enters, "seed {seed}: {front_m}");
            assert!((front_m - 8.5).abs() < 0.07, "seed {seed}: {front_m}");
        }
    }
}

#[test]
fn an_area_that_only_the_uncertainty_still_touches_may_be_left_and_not_approached() {
    let backward = ControllerConfig::Creep { distance_m: -0.6 };
    for (controller, leaves) in [(FOLLOW, true), (backward, false)] {
        let floor = corridor()
            .state("drive", "2", controller, &[])
            .tracking_only(&[Feature::Corridor]);
        for seed in 1..=6 {
            // The rear is 0.17 m off the border, which is known to 0.10 m.
            let mut robot = floor.robot(seed, Pose2::new(5.75, -0.5, 0.0));
            robot.allowed = without(&floor, &["1"]);
            robot.run_for(4.0);
            let driven_m = robot.plant.driven_m;
            let output = robot.output.unwrap();
            if leaves {
                assert!(driven_m > 1.0, "seed {seed}: {output:?}");
            } else {
                assert!(driven_m < 0.01, "seed {seed}: {output:?}");
                assert_eq!(
                    (output.hold, output.waiting_for),
                    (Some(Hold::Border), AreaIndex::new(0))
                );
            }
        }
    }
}

#[test]
fn leave_that_is_taken_back_stops_the_robot_where_it_is() {
    let floor = corridor().state("drive", "1", FOLLOW, &[]);
    let mut robot = floor.robot(7, START);
    robot.run_for(2.5);
    robot.allowed = without(&floor, &["1"]);
    robot.run_for(1.0);
    let stood_m = robot.plant.driven_m;
    robot.run_for(1.0);
    let output = robot.output.unwrap();
    assert!(robot.plant.driven_m - stood_m < 1e-3);
    assert_eq!(
        (output.waiting_for, output.hold),
        (AreaIndex::new(0), Some(Hold::Border))
    );
}

#[test]
fn the_planned_path_round_a_corner_is_what_counts() {
    // Right from the west needs the crossing and the southern arm, and nothing of the east.
    let floor = junction()
        .reached("at-crossing", [-1.2, -1.2], [1.2, 1.2])
        .monitor("turned", MonitorKind::ManoeuvreDone)
        .state("drive", "west-in", FOLLOW, &["at-crossing"])
        .state(
            "turn",
            "south-out",
            ControllerConfig::Turn { radius_m: 0.5 },
            &["turned"],
        )
        .at_speed(0.3)
        .state("on", "south-out", FOLLOW, &[])
        .go("drive", "at-crossing", "turn")
        .go("turn", "turned", "on");
    for seed in 1..=10 {
        let mut robot = floor.robot(seed, Pose2::new(-3.0, -0.5, 0.0));
        let others = ["west-out", "east-in", "east-out", "south-in"];
        robot.allowed = without(&floor, &[&others[..], &["crossing", "south-out"]].concat());
        robot.run_for(10.0);
        assert_eq!(
            robot.output.unwrap().waiting_for,
            AreaIndex::new(6),
            "seed {seed}"
        );
        assert!(front_x_m(&robot) < -1.2, "seed {seed}");
        robot.allowed = without(&floor, &[&others[..], &["south-out"]].concat());
        robot.run_for(12.0);
        let lowest_m = robot.plant.corners().map(|corner| corner.y_m);
        let lowest_m = lowest_m.into_iter().fold(f64::MAX, f64::min);
        assert!(
            lowest_m > -1.2 && lowest_m < -1.0,
            "seed {seed}: {lowest_m}"
        );
        assert_eq!(
            robot.output.unwrap().waiting_for,
            AreaIndex::new(5),
            "seed {seed}"
        );
        robot.allowed = without(&floor, &others);
        robot.run_until("on", 20.0);
        robot.run_for(3.0);
        assert!((robot.plant.pose.x_m + 0.5).abs() < 0.04, "seed {seed}");
    }
}
