//! Where the robot comes to rest: before a border, at a pose, at a dock; creeping; waiting for leave; instructions.

use crate::floor::{Floor, corridor, junction};
use crate::robot::Robot;
use skills::borders::AreaSet;
use skills::control::TurnDirection;
use skills::geometry::Pose2;
use skills::monitors::MonitorKind;
use skills::navigator::{Hold, Instruction, InstructionError};
use skills::schedule::{ControllerSetup, StopTarget};

const START: Pose2 = Pose2::new(2.0, -0.5, 0.0);
const FOLLOW: ControllerSetup = ControllerSetup::Corridor { offset_m: 0.0 };

fn front_x_m(robot: &Robot) -> f64 {
    robot
        .plant
        .corners()
        .iter()
        .map(|corner| corner.x_m)
        .fold(f64::MIN, f64::max)
}

/// From here on the wall at the lane's end comes into view.
const FAR: Pose2 = Pose2::new(5.0, -0.5, 0.0);

fn before(area: &str, margin_m: f64) -> Floor {
    let target = StopTarget::BeforeArea {
        area: area.into(),
        margin_m,
    };
    corridor()
        .monitor("stopped", MonitorKind::ManoeuvreDone)
        .state(
            "approach",
            "2",
            ControllerSetup::StopAt { target },
            &["stopped"],
        )
        .state("wait", "2", ControllerSetup::Stop, &[])
        .state("go", "2", FOLLOW, &[])
        .go("approach", "stopped", "wait")
        .go("wait", "resume", "go")
}

#[test]
fn it_stops_before_a_border_by_its_margin_and_resumes_when_told() {
    for margin_m in [0.03, 0.2] {
        let floor = before("3", margin_m);
        for seed in 1..=12 {
            let mut robot = floor.robot(seed, FAR);
            robot.run_until("wait", 30.0);
            robot.run_for(1.0);
            let left_m = 8.5 - front_x_m(&robot);
            assert!(left_m >= margin_m, "seed {seed}: {left_m}");
            assert!(left_m < margin_m + 0.06, "seed {seed}: {left_m}");
            let stood_m = robot.plant.driven_m;
            robot.run_for(2.0);
            assert!(robot.plant.driven_m - stood_m < 1e-3);
            assert!(robot.navigator.post(robot.events.id("resume").unwrap()));
            robot.run_for(3.0);
            assert_eq!(robot.state(), "go");
            assert!(robot.plant.driven_m > stood_m + 0.5);
            assert_eq!(robot.allocations, 0);
        }
    }
}

#[test]
fn with_side_walls_alone_the_uncertainty_along_the_lane_is_kept_as_margin() {
    // Between 2 m and 5.5 m no wall across the corridor is in view.
    let floor = before("2", 0.03);
    for seed in 1..=12 {
        let mut robot = floor.robot(seed, START);
        robot.run_until("wait", 30.0);
        let left_m = 5.5 - front_x_m(&robot);
        let sigma_m = robot.output.unwrap().covariance[0][0].sqrt();
        assert!(sigma_m > 0.08, "{sigma_m}");
        assert!(left_m >= 0.03, "seed {seed}: {left_m}");
        let margin_m = 0.03 + 3.0 * sigma_m;
        assert!(
            (left_m - margin_m).abs() < 3.0 * sigma_m,
            "seed {seed}: {left_m}"
        );
    }
}

#[test]
fn it_stops_at_a_pose_of_the_site() {
    let pose = Pose2::new(7.9, -0.4, 0.0);
    let target = StopTarget::Pose(pose);
    let floor = corridor()
        .monitor("stopped", MonitorKind::ManoeuvreDone)
        .state(
            "approach",
            "2",
            ControllerSetup::StopAt { target },
            &["stopped"],
        )
        .state("wait", "2", ControllerSetup::Stop, &[])
        .go("approach", "stopped", "wait");
    for seed in 1..=12 {
        let mut robot = floor.robot(seed, FAR);
        robot.run_until("wait", 30.0);
        let truth = robot.plant.pose;
        assert!(
            (truth.x_m - pose.x_m).abs() < 0.02,
            "seed {seed}: {truth:?}"
        );
        assert!(
            (truth.y_m - pose.y_m).abs() < 0.03,
            "seed {seed}: {truth:?}"
        );
        assert!(truth.theta_rad.abs() < 0.04, "seed {seed}: {truth:?}");
    }
}

fn instructed() -> Floor {
    let target = StopTarget::Instructed;
    corridor()
        .monitor("stopped", MonitorKind::ManoeuvreDone)
        .state("drive", "1", FOLLOW, &[])
        .state(
            "approach",
            "1",
            ControllerSetup::StopAt { target },
            &["stopped"],
        )
        .state("wait", "1", ControllerSetup::Stop, &[])
        .go("drive", "come", "approach")
        .go("drive", "slower", "drive")
        .go("approach", "stopped", "wait")
        .go("wait", "go-on", "drive")
}

fn instruction(robot: &Robot, name: &str) -> Instruction {
    Instruction::plain(robot.events.id(name).expect("an event of the machine"))
}

#[test]
fn an_instruction_brings_stop_pose_and_speed_for_its_state_alone() {
    let floor = instructed();
    for seed in 1..=10 {
        let mut robot = floor.robot(seed, FAR);
        robot.run_for(2.0);
        let come = Instruction {
            speed_limit_m_s: Some(0.15),
            stop_at: Some(Pose2::new(7.0, -0.55, 0.05)),
            ..instruction(&robot, "come")
        };
        robot.navigator.instruct(come).unwrap();
        robot.run_for(2.5);
        assert!((robot.output.unwrap().command.speed_m_s - 0.15).abs() < 0.01);
        robot.run_until("wait", 30.0);
        let truth = robot.plant.pose;
        assert!((truth.x_m - 7.0).abs() < 0.03, "seed {seed}: {truth:?}");
        assert!((truth.y_m + 0.55).abs() < 0.03, "seed {seed}: {truth:?}");
        robot.navigator.post(robot.events.id("go-on").unwrap());
        robot.run_for(2.0);
        assert!(robot.output.unwrap().command.speed_m_s > 0.35);
        assert_eq!(robot.allocations, 0);
    }
}

#[test]
fn a_transition_onto_the_same_state_exchanges_the_parameters() {
    let mut robot = instructed().robot(1, FAR);
    robot.run_for(2.0);
    for (limit_m_s, expected_m_s) in [(0.1, 0.1), (0.0, 0.0), (0.3, 0.3)] {
        let slower = Instruction {
            speed_limit_m_s: Some(limit_m_s),
            ..instruction(&robot, "slower")
        };
        robot.navigator.instruct(slower).unwrap();
        robot.run_for(2.0);
        let output = robot.output.unwrap();
        assert!(
            (output.command.speed_m_s - expected_m_s).abs() < 0.01,
            "{output:?}"
        );
        let held = (limit_m_s == 0.0).then_some(Hold::SpeedLimit);
        assert_eq!(output.hold, held);
    }
    // A stop pose on the way, while it follows the lane.
    let x_m = robot.plant.pose.x_m + 0.8;
    let stop = Instruction {
        stop_at: Some(Pose2::new(x_m, -0.5, 0.0)),
        ..instruction(&robot, "slower")
    };
    robot.navigator.instruct(stop).unwrap();
    robot.run_for(8.0);
    assert!((robot.plant.pose.x_m - x_m).abs() < 0.04);
    assert!(robot.output.unwrap().manoeuvre_done);
}

#[test]
fn stop_poses_that_cannot_be_reached_stand_and_say_so() {
    let floor = instructed();
    let cases = [
        (None, Hold::NoStopPose),
        // Behind, too far aside, turned round.
        (Some(Pose2::new(1.6, -0.5, 0.0)), Hold::StopPose),
        (Some(Pose2::new(4.5, 0.5, 0.0)), Hold::StopPose),
        (Some(Pose2::new(4.5, -0.5, 2.0)), Hold::StopPose),
    ];
    for (stop_at, expected) in cases {
        let mut robot = floor.robot(1, START);
        robot.run_for(2.0);
        let come = Instruction {
            stop_at,
            ..instruction(&robot, "come")
        };
        robot.navigator.instruct(come).unwrap();
        robot.run_for(3.0);
        let output = robot.output.unwrap();
        assert_eq!(
            (output.hold, output.command.speed_m_s),
            (Some(expected), 0.0)
        );
        assert!(!output.manoeuvre_done && robot.state() == "approach");
    }
    let mut robot = floor.robot(1, START);
    let come = instruction(&robot, "come");
    let bad = Instruction {
        speed_limit_m_s: Some(-1.0),
        ..come
    };
    assert_eq!(
        robot.navigator.instruct(bad),
        Err(InstructionError::SpeedLimit(-1.0))
    );
    let bad = Instruction {
        stop_at: Some(Pose2::new(f64::NAN, 0.0, 0.0)),
        ..come
    };
    assert_eq!(
        robot.navigator.instruct(bad),
        Err(InstructionError::StopPose)
    );
}

/// Dock at the east wall, creep back, turn, go home.
fn docking() -> Floor {
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
        .monitor("served", MonitorKind::After { seconds: 1.0 })
        .monitor("clear", MonitorKind::ManoeuvreDone)
        .monitor("turned", MonitorKind::ManoeuvreDone)
        .state("drive", "access", FOLLOW, &["in-bay"])
        .state(
            "dock",
            "bay",
            ControllerSetup::Dock { distance_m: 0.3 },
            &["docked"],
        )
        .searching_the_end()
        .state("served", "bay", ControllerSetup::Stop, &["served"])
        .state(
            "creep",
            "bay",
            ControllerSetup::Creep { distance_m: -0.6 },
            &["clear"],
        )
        .state(
            "turn",
            "bay",
            ControllerSetup::UTurn {
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
                ControllerSetup::Creep { distance_m },
                &["done"],
            )
            .state("stop", "2", ControllerSetup::Stop, &[])
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

fn without(floor: &Floor, areas: &[&str]) -> AreaSet {
    let mut allowed = AreaSet::ALL;
    for id in areas {
        let index = floor.map.areas.iter().position(|area| area.id == *id);
        allowed.remove(index.expect("an area"));
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
        assert_eq!(output.waiting_for, Some(2), "seed {seed}: {output:?}");
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
        (Some(0), Some(Hold::Border))
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
            ControllerSetup::Turn { radius_m: 0.5 },
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
        assert_eq!(robot.output.unwrap().waiting_for, Some(6), "seed {seed}");
        assert!(front_x_m(&robot) < -1.2, "seed {seed}");
        robot.allowed = without(&floor, &[&others[..], &["south-out"]].concat());
        robot.run_for(12.0);
        let lowest_m = robot.plant.corners().map(|corner| corner.y_m);
        let lowest_m = lowest_m.into_iter().fold(f64::MAX, f64::min);
        assert!(
            lowest_m > -1.2 && lowest_m < -1.0,
            "seed {seed}: {lowest_m}"
        );
        assert_eq!(robot.output.unwrap().waiting_for, Some(5), "seed {seed}");
        robot.allowed = without(&floor, &others);
        robot.run_until("on", 20.0);
        robot.run_for(3.0);
        assert!((robot.plant.pose.x_m + 0.5).abs() < 0.04, "seed {seed}");
    }
}
