use crate::closed_loop::floor::lidar;
use crate::closed_loop::robot::{Robot, Trouble};
use crate::closed_loop::site;
use crate::random::Random;
use description::geometry::{Point2, Pose2, Rect, Twist2};
use skills::borders::AreaSet;
use skills::history::OdometryHistory;
use skills::navigator::{NavigationInput, NavigationOutput, Navigator};
use skills::odometry::Odometry;
use skills::scan::AlignedScan;

const START: Pose2 = Pose2::new(2.0, -0.5, 0.0);

fn run(robot: &mut Robot, seconds: f64) -> NavigationOutput {
    for _ in 0..(seconds * 1e3) as u64 {
        robot.step();
        assert!(
            robot.plant.clearance_within_m(0.1).is_none(),
            "{:?}",
            robot.output
        );
    }
    assert_eq!(robot.allocations, 0);
    robot.output.expect("navigation ran")
}

fn lateral_m(robot: &Robot) -> f64 {
    (robot.plant.pose.y_m + 0.5).abs()
}

#[test]
fn some_seconds_without_scans_are_bridged_and_the_covariance_says_so() {
    let mut robot = Robot::new(1, START);
    let before = run(&mut robot, 3.0);
    robot.trouble.no_scans = true;
    let blind = run(&mut robot, 3.0);
    assert!(blind.counters.scans <= before.counters.scans + 1);
    assert!(blind.corridor.unwrap().lateral_std_m > 2.0 * before.corridor.unwrap().lateral_std_m);
    assert!(!blind.pose_uncertain && lateral_m(&robot) < 0.1);
    robot.trouble.no_scans = false;
    let after = run(&mut robot, 1.0);
    assert!(after.corridor.unwrap().lateral_std_m < 0.02 && lateral_m(&robot) < 0.1);
}

#[test]
fn without_scans_for_good_it_stops() {
    let mut robot = Robot::new(2, START);
    run(&mut robot, 2.0);
    robot.trouble.no_scans = true;
    let output = run(&mut robot, 40.0);
    let halted = robot
        .navigator
        .machine()
        .state_name(output.state)
        .starts_with("halt");
    assert!(output.pose_uncertain || halted, "{output:?}");
    assert_eq!(output.command.speed_m_s, 0.0);
}

#[test]
fn scans_that_say_nothing_are_bridged_and_then_end_in_a_stop() {
    // All free; all unknown; a mixture of codes.
    for (low, high) in [(0, 0), (7, 7), (0, 19)] {
        let mut robot = Robot::new(3, START);
        let before = run(&mut robot, 2.0);
        robot.trouble.codes = Some((low, high));
        let blind = run(&mut robot, 1.2);
        assert!(blind.position_std_m >= before.position_std_m);
        assert!(lateral_m(&robot) < 0.1 && !blind.pose_uncertain);
        // Always the same code counts as a frozen lidar: as no scan, that is, not as a blind one.
        let stopped = run(&mut robot, 2.0);
        assert_eq!(
            stopped.pose_uncertain,
            low != 7,
            "{low}..={high}: {stopped:?}"
        );
        robot.trouble.codes = None;
        let back = run(&mut robot, 2.0);
        assert!(
            !back.pose_uncertain && back.command.speed_m_s > 0.2,
            "{back:?}"
        );
    }
}

#[test]
fn a_frozen_lidar_pulls_nothing() {
    let mut robot = Robot::new(4, START);
    run(&mut robot, 8.0);
    robot.trouble.frozen_scans = true;
    run(&mut robot, 3.0);
    assert!(lateral_m(&robot) < 0.05);
    robot.trouble.frozen_scans = false;
    // Through the lane's end and the turn.
    run(&mut robot, 25.0);
    let output = robot.output.unwrap();
    let off_m = robot
        .plant
        .pose
        .position()
        .distance_m(output.pose.position());
    assert!(off_m < 0.06, "{off_m}");
}

#[test]
fn jumping_encoders_are_counted_and_driven_through() {
    let mut robot = Robot::new(5, START);
    robot.trouble = Trouble {
        left_encoder_jumps: true,
        pivot_encoder_jumps: true,
        ..Trouble::default()
    };
    for _ in 0..45 {
        run(&mut robot, 1.0);
        let turning = robot.plant.pose.x_m < 1.8 || robot.plant.pose.x_m > 8.2;
        let lane_m = if robot.plant.pose.theta_rad.abs() < 1.57 {
            -0.5
        } else {
            0.5
        };
        assert!(turning || (robot.plant.pose.y_m - lane_m).abs() < 0.1);
    }
    assert!(robot.dead_reckoning.counters().jumps > 90);
    assert!(robot.plant.driven_m > 14.0);
}

#[test]
fn things_that_stand_by_the_walls_are_no_walls() {
    let mut robot = Robot::new(6, START);
    robot.plant.obstacles = vec![
        Rect::new(Point2::new(3.5, 1.2), Point2::new(4.1, 1.6)),
        Rect::new(Point2::new(6.0, 1.15), Point2::new(7.4, 1.5)),
        Rect::new(Point2::new(5.0, -1.6), Point2::new(5.8, -1.4)),
        Rect::new(Point2::new(9.6, -0.4), Point2::new(9.9, 0.1)),
    ];
    for _ in 0..50 {
        let output = run(&mut robot, 1.0);
        let off_m = robot
            .plant
            .pose
            .position()
            .distance_m(output.pose.position());
        assert!(off_m < 0.08 && !output.pose_uncertain, "{off_m} {output:?}");
        let turning = robot.plant.pose.x_m < 1.8 || robot.plant.pose.x_m > 8.2;
        let lane_m = if robot.plant.pose.theta_rad.abs() < 1.57 {
            -0.5
        } else {
            0.5
        };
        assert!(turning || (robot.plant.pose.y_m - lane_m).abs() < 0.1);
    }
    assert!(robot.plant.driven_m > 17.0);
}

#[test]
fn a_robot_put_down_wrongly_finds_itself() {
    for (seed, off) in [
        (7, Pose2::new(0.25, 0.12, 0.1)),
        (8, Pose2::new(-0.25, -0.12, -0.1)),
    ] {
        let mut robot = Robot::new(seed, START);
        robot.plant.pose = START.compose(off);
        run(&mut robot, 6.0);
        assert!(lateral_m(&robot) < 0.05, "{}", lateral_m(&robot));
        run(&mut robot, 14.0);
        let output = robot.output.unwrap();
        let off_m = robot
            .plant
            .pose
            .position()
            .distance_m(output.pose.position());
        assert!(off_m < 0.06, "{off_m} {output:?}");
    }
}

#[test]
fn a_robot_in_another_place_than_believed_stops() {
    let mut robot = Robot::new(9, START);
    robot.plant.pose = Pose2::new(5.0, 0.0, 1.2);
    let output = run(&mut robot, 6.0);
    assert!(
        output.pose_uncertain && output.command.speed_m_s == 0.0,
        "{output:?}"
    );
    assert!(robot.plant.driven_m < 1.5, "{}", robot.plant.driven_m);
    let (truth, believed) = (robot.plant.pose, output.pose);
    assert!(truth.position().distance_m(believed.position()) > 0.3);
    assert!(robot.navigator.relocate(truth, 0.1, 0.1));
    assert!(!run(&mut robot, 0.5).pose_uncertain);
}

#[test]
fn when_motion_is_not_allowed_it_waits_and_goes_on() {
    let mut robot = Robot::new(10, START);
    run(&mut robot, 3.0);
    robot.motion_allowed = false;
    let waiting = run(&mut robot, 2.0);
    let driven_m = robot.plant.driven_m;
    run(&mut robot, 2.0);
    assert_eq!(waiting.command.speed_m_s, 0.0);
    assert!(robot.plant.driven_m - driven_m < 1e-6);
    robot.motion_allowed = true;
    run(&mut robot, 2.0);
    assert!(robot.plant.driven_m > driven_m + 0.5 && lateral_m(&robot) < 0.05);
}

#[test]
fn posted_events_reach_the_machine() {
    let mut robot = Robot::new(11, START);
    run(&mut robot, 1.0);
    let strayed = robot.events.id("strayed").unwrap();
    let reset = robot.events.id("reset").unwrap();
    robot.navigator.post(strayed);
    let halted = run(&mut robot, 2.0);
    assert_eq!(robot.navigator.machine().state_name(halted.state), "halt-1");
    assert!(halted.command.speed_m_s == 0.0 && halted.corridor.is_some());
    robot.navigator.post(reset);
    let output = run(&mut robot, 2.0);
    assert_eq!(robot.navigator.skill_name(output.skill), "follow-lane");
    let taken = (0..40).filter(|_| robot.navigator.post(reset)).count();
    assert_eq!(taken, skills::navigator::MAX_EVENTS);
}

#[test]
fn whatever_comes_in_the_command_is_a_sane_number() {
    let mut random = Random::new(12);
    let mut navigator = Navigator::new(site::setup(START)).unwrap();
    let events = navigator.events().clone();
    let mut history = OdometryHistory::default();
    let mut scan = AlignedScan::new(lidar()).unwrap();
    let mut raw = vec![0; lidar().beams];
    let mut odometry = Odometry::default();
    for step in 10..4000u64 {
        let now_ns = step * 50_000_000;
        let mut number = |scale: f64| match (random.uniform() * 40.0) as u32 {
            0 => f64::NAN,
            1 => f64::INFINITY,
            2 => 1e300,
            _ => random.between(-scale, scale),
        };
        odometry.stamp_ns = now_ns;
        odometry.pose = Pose2::new(number(20.0), number(20.0), number(4.0));
        odometry.twist = Twist2::new(number(1.0), number(1.0));
        odometry.distance_m += number(1.0);
        odometry.turned_rad += number(1.0);
        let _ = history.push(now_ns, odometry.pose, odometry.twist);
        raw.fill_with(|| random.between(0.0, 5000.0) as u16);
        let _ = scan.align(&raw, now_ns - 100_000_000 * (step % 3).min(1), &history);
        for name in [
            "in-2",
            "end-stable",
            "lane-ended",
            "turned",
            "strayed",
            "reset",
        ] {
            if random.uniform() < 0.1 {
                navigator.post(events.id(name).unwrap());
            }
        }
        let output = navigator.step(&NavigationInput {
            now_ns: if step % 50 == 0 { 0 } else { now_ns },
            scan: Some(&scan),
            odometry: &odometry,
            lost: false,
            motion_allowed: true,
            by_hand: None,
            allowed: AreaSet::ALL,
        });
        assert!(
            output.command.is_finite() && output.pose.is_finite(),
            "{output:?}"
        );
        assert!(output.command.speed_m_s.abs() <= 0.4 && output.command.curvature_1_m.abs() <= 2.5);
        assert!(
            output
                .covariance
                .as_flattened()
                .iter()
                .all(|number| number.is_finite())
        );
    }
}
