//! Where the robot comes to rest: before a border, at a pose; instructions.

use crate::closed_loop::floor::{Floor, corridor};
use crate::closed_loop::robot::Robot;
use description::geometry::Pose2;
use description::site::{ControllerConfig, MonitorKind, StopPlace};
use skills::navigator::{Hold, Instruction, InstructionError, Parameters};

pub const START: Pose2 = Pose2::new(2.0, -0.5, 0.0);
const FOLLOW: ControllerConfig = ControllerConfig::Corridor { offset_m: 0.0 };

pub fn front_x_m(robot: &Robot) -> f64 {
    robot
        .plant
        .corners()
        .iter()
        .map(|corner| corner.x_m)
        .fold(f64::MIN, f64::max)
}

/// From here on the wall at the lane's end comes into view.
pub const FAR: Pose2 = Pose2::new(5.0, -0.5, 0.0);

fn before(area: &str, margin_m: f64) -> Floor {
    let place = StopPlace::BeforeArea {
        area: area.into(),
        margin_m,
    };
    corridor()
        .monitor("stopped", MonitorKind::ManoeuvreDone)
        .state(
            "approach",
            "2",
            ControllerConfig::StopAt { place },
            &["stopped"],
        )
        .state("wait", "2", ControllerConfig::Stop, &[])
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

/// A stop at this pose.
fn at(pose: Pose2) -> Floor {
    let place = StopPlace::Pose(pose);
    corridor()
        .monitor("stopped", MonitorKind::ManoeuvreDone)
        .state(
            "approach",
            "2",
            ControllerConfig::StopAt { place },
            &["stopped"],
        )
        .state("wait", "2", ControllerConfig::Stop, &[])
        .go("approach", "stopped", "wait")
}

#[test]
fn it_stops_at_a_pose_of_the_site() {
    let pose = Pose2::new(7.9, -0.4, 0.0);
    let floor = at(pose);
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

#[test]
fn a_robot_that_has_driven_past_comes_back_slowly_but_not_from_anywhere() {
    let to = Pose2::new(7.5, -0.5, 0.0);
    let border = before("3", 0.03);
    for past_m in [0.08, 0.3, 0.45] {
        // The front is to stop that far before the border, and as much farther as the pose is uncertain.
        let before_m = 8.5 - 0.32 - 0.03;
        let floors = [(at(to), to.x_m, 0.04), (border.clone(), before_m, 0.4)];
        for (floor, x_m, most_m) in floors {
            for seed in 1..=4 {
                let mut robot = floor.robot(seed, Pose2::new(x_m + past_m, -0.5, 0.0));
                let mut fastest_m_s = 0.0_f64;
                let mut looks = 0;
                while robot.state() != "wait" {
                    robot.run_for(0.1);
                    let command = robot.output.map_or(0.0, |own| own.command.speed_m_s);
                    assert!(command < 0.01, "forward at {command} m/s");
                    fastest_m_s = fastest_m_s.max(-command);
                    looks += 1;
                    assert!(looks < 200, "past {past_m} m, seed {seed}: it stands");
                }
                assert!(fastest_m_s > 0.03 && fastest_m_s < 0.11, "{fastest_m_s}");
                let left_m = x_m - robot.plant.pose.x_m;
                assert!(
                    (-0.04..most_m).contains(&left_m),
                    "past {past_m} m, seed {seed}: {left_m}"
                );
                assert_eq!(robot.allocations, 0);
            }
        }
    }
    let mut robot = at(to).robot(1, Pose2::new(to.x_m + 0.6, -0.5, 0.0));
    robot.run_for(10.0);
    let output = robot.output.expect("a step");
    assert_eq!(
        (robot.state(), output.hold),
        ("approach", Some(Hold::StopPose))
    );
}

fn instructed() -> Floor {
    let place = StopPlace::Instructed;
    corridor()
        .monitor("stopped", MonitorKind::ManoeuvreDone)
        .state("drive", "1", FOLLOW, &[])
        .state(
            "approach",
            "1",
            ControllerConfig::StopAt { place },
            &["stopped"],
        )
        .state("wait", "1", ControllerConfig::Stop, &[])
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

/// What has come true in a state that an instruction ends in the same step means nothing to the next one.
#[test]
fn an_event_of_a_state_is_not_that_of_the_one_into_which_it_was_sent() {
    let floor = corridor()
        .monitor("waited", MonitorKind::After { after_s: 1.0 })
        .state("first", "1", ControllerConfig::Stop, &["waited"])
        .state("second", "1", ControllerConfig::Stop, &[])
        .state("third", "1", ControllerConfig::Stop, &[])
        .go("first", "go-on", "second")
        .go("first", "waited", "third")
        .go("second", "waited", "third");
    let mut before = 0;
    for step in 0..40 {
        let mut robot = floor.robot(1, FAR);
        let mut steps = 0;
        while steps < step {
            steps += u32::from(robot.step().is_some());
        }
        let was = robot.state().to_owned();
        let go_on = robot.events.id("go-on").expect("an event of the machine");
        assert!(robot.navigator.post(go_on));
        robot.run_for(0.5);
        before += u32::from(was == "first");
        let expected = if was == "first" { "second" } else { "third" };
        assert_eq!(robot.state(), expected, "after {step} steps");
    }
    assert!((5..40).contains(&before), "{before}");
}

#[test]
fn parameters_are_exchanged_and_cleared_without_an_event() {
    let mut robot = instructed().robot(1, FAR);
    robot.run_for(2.0);
    let state = robot.state().to_owned();
    let limits = [(Some(0.1), 0.1), (Some(0.0), 0.0), (Some(0.2), 0.2)];
    for (speed_limit_m_s, expected_m_s) in limits {
        let parameters = Parameters {
            speed_limit_m_s,
            ..Parameters::default()
        };
        robot.navigator.set_parameters(parameters).unwrap();
        robot.run_for(2.0);
        let output = robot.output.unwrap();
        assert!(
            (output.command.speed_m_s - expected_m_s).abs() < 0.01,
            "{output:?}"
        );
        let bad = Parameters {
            speed_limit_m_s: Some(f64::NAN),
            ..parameters
        };
        assert!(robot.navigator.set_parameters(bad).is_err());
        assert_eq!(robot.navigator.parameters(), parameters);
    }
    let x_m = robot.plant.pose.x_m + 0.6;
    let stop = Parameters {
        stop_at: Some(Pose2::new(x_m, -0.5, 0.0)),
        ..Parameters::default()
    };
    robot.navigator.set_parameters(stop).unwrap();
    robot.run_for(8.0);
    assert!((robot.plant.pose.x_m - x_m).abs() < 0.04);
    // The same again changes nothing; nothing at all lets it drive on.
    robot.navigator.set_parameters(stop).unwrap();
    robot.run_for(1.0);
    assert!(robot.output.unwrap().manoeuvre_done);
    robot
        .navigator
        .set_parameters(Parameters::default())
        .unwrap();
    robot.run_for(2.0);
    assert!(robot.output.unwrap().command.speed_m_s > 0.3);
    assert_eq!((robot.state(), robot.allocations), (state.as_str(), 0));
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
