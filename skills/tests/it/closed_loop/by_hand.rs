//! Driven by hand: borders hold, the machine waits, and the robot goes on from where it was driven.

use crate::closed_loop::floor::corridor;
use crate::closed_loop::robot::Robot;
use crate::closed_loop::stops::{FAR, START, front_x_m};
use description::areas::AreaIndex;
use description::geometry::{Pose2, Twist2};
use description::site::{ControllerConfig, Feature};
use skills::borders::AreaSet;
use skills::navigator::{ByHand, Hold};

const FOLLOW: ControllerConfig = ControllerConfig::Corridor { offset_m: 0.0 };
const LIMIT_M_S: f64 = 0.2;
const CREEP_M_S: f64 = 0.1;

fn wants(v_m_s: f64, omega_rad_s: f64) -> Option<ByHand> {
    Some(ByHand {
        wish: Twist2::new(v_m_s, omega_rad_s),
        limit_m_s: LIMIT_M_S,
        creep_m_s: CREEP_M_S,
        without_borders: false,
    })
}

fn only(areas: &[usize]) -> AreaSet {
    { areas.iter() }
        .filter_map(|&area| AreaIndex::new(area))
        .collect()
}

fn speed_m_s(robot: &Robot) -> f64 {
    robot.output.map_or(0.0, |output| output.command.speed_m_s)
}

#[test]
fn it_drives_what_the_hand_wants_no_faster_than_it_may_and_stands_when_let_go() {
    let floor = corridor().state("drive", "1", FOLLOW, &[]);
    let mut robot = floor.robot(1, START);
    robot.by_hand = wants(0.0, 0.0);
    robot.run_for(1.0);
    assert_eq!(
        robot
            .output
            .map(|output| (output.command.speed_m_s, output.hold)),
        Some((0.0, Some(Hold::ByHand)))
    );
    robot.by_hand = wants(1.0, 1.0);
    robot.run_for(2.0);
    let command = robot.output.expect("it stepped").command;
    assert_eq!((command.speed_m_s, command.curvature_1_m), (LIMIT_M_S, 1.0));
    robot.by_hand = wants(0.0, 1.0);
    robot.run_for(0.1);
    assert_eq!(speed_m_s(&robot), 0.0, "it does not turn on the spot");
    robot.by_hand = wants(-0.1, 1.0);
    robot.run_for(2.0);
    let command = robot.output.expect("it stepped").command;
    assert_eq!((command.speed_m_s, command.curvature_1_m), (-0.1, -2.5));
    for no_number in [f64::NAN, f64::INFINITY] {
        for wish in [wants(no_number, 0.0), wants(0.1, no_number)] {
            robot.by_hand = wish;
            robot.run_for(0.1);
            assert_eq!(speed_m_s(&robot), 0.0);
        }
    }
    assert_eq!(robot.allocations, 0);
}

#[test]
fn an_area_without_leave_is_not_entered_by_hand_and_asked_for() {
    // Area 3 begins at 8.5 m.
    let floor = corridor().state("drive", "2", FOLLOW, &[]);
    for (seed, turn_rad_s) in [(1, 0.0), (2, 0.05), (3, -0.05)] {
        let mut robot = floor.robot(seed, FAR);
        robot.allowed = only(&[0, 1]);
        robot.by_hand = wants(0.4, turn_rad_s);
        for _ in 0..250 {
            robot.run_for(0.1);
            assert!(front_x_m(&robot) < 8.5, "seed {seed}");
        }
        let output = robot.output.expect("it stepped");
        assert!(output.waiting_for.is_some(), "{output:?}");
        assert_eq!(
            (output.hold, output.command.speed_m_s),
            (Some(Hold::Border), 0.0)
        );
        robot.by_hand = wants(-0.1, 0.0);
        let before_m = front_x_m(&robot);
        robot.run_for(2.0);
        assert!(front_x_m(&robot) < before_m - 0.1, "it may go back");
    }
}

#[test]
fn out_of_an_area_without_leave_it_is_driven_and_not_deeper_into_it() {
    let floor = corridor().state("drive", "2", FOLLOW, &[]);
    // Across the border at 8.5 m: its front is in area 3.
    let across = Pose2::new(8.3, -0.5, 0.0);
    let mut robot = floor.robot(4, across);
    robot.allowed = only(&[0, 1]);
    robot.by_hand = wants(0.2, 0.0);
    let before_m = front_x_m(&robot);
    robot.run_for(2.0);
    assert!(front_x_m(&robot) < before_m + 0.01, "deeper");
    robot.by_hand = wants(-0.1, 0.0);
    robot.run_for(4.0);
    assert!(front_x_m(&robot) < before_m - 0.2, "out");
}

#[test]
fn without_a_place_it_creeps_where_nobody_manages_areas_or_somebody_sees_to_them() {
    let floor = corridor()
        .state("drive", "1", FOLLOW, &[])
        .tracking_only(&[Feature::Corridor]);
    let mut robot = floor.robot(5, START);
    robot.run_for(2.0);
    robot.trouble.codes = Some((0, 19));
    robot.run_for(6.0);
    assert!(robot.output.is_some_and(|output| output.pose_uncertain));
    robot.by_hand = wants(0.3, 0.0);
    robot.run_for(1.0);
    assert_eq!(speed_m_s(&robot), CREEP_M_S);
    robot.allowed = only(&[0, 1]);
    robot.run_for(1.0);
    let held = robot
        .output
        .map(|output| (output.command.speed_m_s, output.hold));
    assert_eq!(held, Some((0.0, Some(Hold::PoseUncertain))));
    robot.by_hand = robot.by_hand.map(|hand| ByHand {
        without_borders: true,
        ..hand
    });
    robot.run_for(1.0);
    assert_eq!(speed_m_s(&robot), CREEP_M_S);
    // In no area at all it may be, so nobody knows where it is, however sure it may be itself.
    let mut robot = floor.robot(6, START);
    robot.allowed = AreaSet::EMPTY;
    robot.by_hand = wants(0.3, 0.0);
    robot.run_for(1.0);
    assert_eq!(speed_m_s(&robot), 0.0);
}

#[test]
fn monitors_rest_meanwhile_and_it_goes_on_from_where_it_was_driven() {
    let floor = corridor()
        .state("drive", "1", FOLLOW, &["there"])
        .state("there", "2", FOLLOW, &[])
        .reached("there", [3.0, -1.5], [5.0, 1.5])
        .go("drive", "there", "there");
    let mut robot = floor.robot(7, START);
    robot.by_hand = wants(0.2, 0.0);
    while robot.plant.pose.x_m < 3.3 {
        robot.run_for(0.1);
    }
    let state = |robot: &Robot| {
        let machine = robot.navigator.machine();
        machine.state_name(machine.state()).to_owned()
    };
    assert_eq!(state(&robot), "drive");
    robot.by_hand = None;
    robot.motion_allowed = false;
    robot.run_for(1.0);
    assert_eq!(
        (state(&robot), speed_m_s(&robot)),
        ("drive".to_owned(), 0.0)
    );
    robot.motion_allowed = true;
    robot.run_for(2.0);
    assert!(state(&robot) == "there" && speed_m_s(&robot) > LIMIT_M_S);
}
