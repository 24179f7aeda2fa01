//! Docking at a wall, and creeping.

use crate::closed_loop::floor::{Floor, corridor};
use crate::closed_loop::stops::front_x_m;
use description::geometry::Pose2;
use description::site::{ControllerConfig, MonitorKind, TurnDirection};

const FOLLOW: ControllerConfig = ControllerConfig::Corridor { offset_m: 0.0 };

/// Dock at the east wall, creep back, turn, go home.
pub fn docking() -> Floor {
    Floor::default()
        .wall("south", [0.0, -1.2], [12.0, -1.2])
        .wall("north", [0.0, 1.2], [12.0, 1.2])
        .wall("east", [12.0, -1.2], [12.0, 1.2])
        .wall("west", [0.0, -1.2], [0.0, 1.2])
        .lane("in", [1.2, -0.5], [11.4, -0.5], Some("east"))
        .lane("out", [11.4, 0.5], [1.2, 0.5], Some("west"))
        .area("access", [4.0, -1.2], [8.0, 0.0], Some("in"), 0.4)
        .area("bay", [8.0, -1.2], [12.0, 1.2], Some("in"), 0.3)
        .area("back", [4.0, 0.0], [8.0, 1.2], Some("out"), 0.4)
        .reached("in-bay", [8.0, -1.2], [12.0, 1.2])
        .monitor("docked", MonitorKind::ManoeuvreDone)
        .monitor("served", MonitorKind::After { after_s: 1.0 })
        .monitor("clear", MonitorKind::ManoeuvreDone)
        .monitor("turned", MonitorKind::ManoeuvreDone)
        .state("drive", "access", FOLLOW, &["in-bay"])
        .state(
            "dock",
            "bay",
            ControllerConfig::Dock { distance_m: 0.3 },
            &["docked"],
        )
        .searching_the_end()
        .state("served", "bay", ControllerConfig::Stop, &["served"])
        .state(
            "creep",
            "bay",
            ControllerConfig::Creep { distance_m: -0.6 },
            &["clear"],
        )
        .state(
            "turn",
            "bay",
            ControllerConfig::UTurn {
                direction: TurnDirection::Left,
                radius_m: 0.5,
            },
            &["turned"],
        )
        .state("home", "back", FOLLOW, &[])
        .go("drive", "in-bay", "dock")
        .go("dock", "docked", "served")
        .go("served", "served", "creep")
        .go("creep", "clear", "turn")
        .go("turn", "turned", "home")
}

#[test]
fn it_docks_within_two_centimetres_creeps_back_and_turns() {
    let floor = docking();
    let (mut worst_m, mut slowest_s): (f64, f64) = (0.0, 0.0);
    for seed in 1..=30 {
        let mut robot = floor.robot(seed, Pose2::new(7.0, -0.5, 0.0));
        robot.run_until("dock", 20.0);
        let began_ns = robot.plant.now_ns;
        let mut before_m = robot.plant.driven_m;
        while robot.state() == "dock" {
            robot.run_for(0.1);
            let speed_m_s = (robot.plant.driven_m - before_m) / 0.1;
            before_m = robot.plant.driven_m;
            let left_m = 12.0 - front_x_m(&robot) - 0.3;
            assert!(left_m > 0.95 || speed_m_s < 0.16, "{left_m} {speed_m_s}");
            let took_s = (robot.plant.now_ns - began_ns) as f64 * 1e-9;
            assert!(took_s < 60.0, "seed {seed}: {:?}", robot.output);
            slowest_s = slowest_s.max(took_s);
        }
        let docked_m = 12.0 - front_x_m(&robot);
        worst_m = worst_m.max((docked_m - 0.3).abs());
        assert!((docked_m - 0.3).abs() < 0.02, "seed {seed}: {docked_m}");
        assert!((robot.plant.pose.y_m + 0.5).abs() < 0.03, "seed {seed}");
        robot.run_until("creep", 5.0);
        let (from, driven_m) = (robot.plant.pose, robot.plant.driven_m);
        robot.run_until("turn", 20.0);
        let moved = from.between(robot.plant.pose);
        assert!((moved.x_m + 0.6).abs() < 0.03, "seed {seed}: {moved:?}");
        assert!(
            moved.y_m.abs() < 0.03 && moved.theta_rad.abs() < 0.06,
            "seed {seed}: {moved:?}"
        );
        assert!(robot.plant.driven_m - driven_m < 0.64);
        robot.run_until("home", 30.0);
        robot.run_for(3.0);
        assert!((robot.plant.pose.y_m - 0.5).abs() < 0.03, "seed {seed}");
        assert_eq!(robot.allocations, 0);
    }
    println!(
        "worst dock {:.1} mm, slowest {slowest_s:.1} s",
        worst_m * 1e3
    );
}

#[test]
fn a_dock_that_is_not_seen_is_not_approached() {
    let mut robot = docking().robot(3, Pose2::new(7.5, -0.5, 0.0));
    robot.plant.walls[2].a.x_m = 14.5;
    robot.plant.walls[2].b.x_m = 14.5;
    robot.plant.walls[0].b.x_m = 14.5;
    robot.plant.walls[1].b.x_m = 14.5;
    robot.run_for(30.0);
    let output = robot.output.unwrap();
    assert!(
        output.hold.is_some() && output.command.speed_m_s == 0.0,
        "{output:?}"
    );
    assert_eq!(robot.state(), "dock");
    assert!(front_x_m(&robot) < 11.5, "{output:?}");
}

#[test]
fn creeping_holds_its_line_in_both_directions_from_a_bad_start() {
    for (distance_m, heading_rad) in [(-1.2, 0.12), (-1.2, -0.12), (0.5, 0.1)] {
        let floor = corridor()
            .monitor("done", MonitorKind::ManoeuvreDone)
            .state(
                "creep",
                "2",
                ControllerConfig::Creep { distance_m },
                &["done"],
            )
            .state("stop", "2", ControllerConfig::Stop, &[])
            .go("creep", "done", "stop");
        for seed in 1..=10 {
            let start = Pose2::new(7.5, -0.5, heading_rad);
            let mut robot = floor.robot(seed, start);
            let from = robot.plant.pose;
            robot.run_until("stop", 30.0);
            let pose = robot.plant.pose;
            let moved_m = pose.x_m - from.x_m;
            assert!((moved_m - distance_m).abs() < 0.05, "seed {seed}: {pose:?}");
            let off_m = pose.y_m - from.y_m;
            assert!(
                off_m.abs() < 0.06 && pose.theta_rad.abs() < 0.08,
                "seed {seed}: {pose:?}"
            );
            assert_eq!(robot.allocations, 0);
        }
    }
}
