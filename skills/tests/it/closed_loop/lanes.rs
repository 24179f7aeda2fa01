//! Along lanes: at an offset, to the shoulder and back, U-turns to both sides, speeds.

use crate::closed_loop::floor::{Floor, corridor};
use crate::closed_loop::robot::Robot;
use description::geometry::{Pose2, wrap_angle};
use description::site::{ControllerConfig, Feature, MonitorKind, TurnDirection};

const START: Pose2 = Pose2::new(2.0, -0.5, 0.0);
const SEEDS: u64 = 8;

fn follow(offset_m: f64) -> ControllerConfig {
    ControllerConfig::Corridor { offset_m }
}

#[test]
fn a_lane_is_followed_at_an_offset() {
    for offset_m in [0.25, -0.3] {
        let floor = corridor()
            .reached("in-2", [5.5, -1.6], [8.5, 0.0])
            .state("beside", "1", follow(offset_m), &["in-2"])
            .state("there", "2", ControllerConfig::Stop, &[])
            .go("beside", "in-2", "there");
        for seed in 1..=SEEDS {
            let mut robot = floor.robot(seed, START);
            while robot.plant.pose.x_m < 4.7 {
                robot.run_for(0.1);
            }
            while robot.plant.pose.x_m < 5.3 {
                robot.run_for(0.05);
                let off_m = robot.plant.pose.y_m + 0.5 - offset_m;
                assert!(off_m.abs() < 0.03, "seed {seed}: {off_m}");
                assert!(robot.output.unwrap().lateral_error_m.abs() < 0.03);
            }
            robot.run_until("there", 5.0);
            assert_eq!(robot.allocations, 0);
        }
    }
}

/// Drive, shift to the shoulder, wait, shift back, drive on.
fn shoulder() -> Floor {
    let shift = |within_m| ControllerConfig::Shift {
        offset_m: 0.0,
        within_m,
    };
    corridor()
        .reached("at-shoulder", [2.6, -0.9], [5.5, 0.0])
        .reached("in-2", [5.5, -1.6], [8.5, 0.0])
        .monitor("beside", MonitorKind::ManoeuvreDone)
        .monitor("back", MonitorKind::ManoeuvreDone)
        .monitor("waited", MonitorKind::After { after_s: 2.0 })
        .state("drive", "1", follow(0.0), &["at-shoulder"])
        .state("shift-in", "5", shift(1.5), &["beside"])
        .state("wait", "5", ControllerConfig::Stop, &["waited"])
        .state("shift-out", "1", shift(1.5), &["back"])
        .state("on", "1", follow(0.0), &["in-2"])
        .state("end", "2", ControllerConfig::Stop, &[])
        .go("drive", "at-shoulder", "shift-in")
        .go("shift-in", "beside", "wait")
        .go("wait", "waited", "shift-out")
        .go("shift-out", "back", "on")
        .go("on", "in-2", "end")
}

#[test]
fn onto_the_shoulder_wait_and_back() {
    let floor = shoulder();
    for seed in 1..=SEEDS {
        let mut robot = floor.robot(seed, START);
        robot.run_until("shift-in", 20.0);
        robot.run_until("wait", 20.0);
        let began_ns = robot.plant.now_ns;
        robot.run_for(1.0);
        let pose = robot.plant.pose;
        assert!((pose.y_m + 1.2).abs() < 0.04, "seed {seed}: {pose:?}");
        assert!(pose.theta_rad.abs() < 0.08, "seed {seed}: {pose:?}");
        assert!(pose.x_m < 4.6, "seed {seed}: {pose:?}");
        let (still_m, speed_m_s) = (
            robot.plant.driven_m,
            robot.output.unwrap().command.speed_m_s,
        );
        assert_eq!(speed_m_s, 0.0);
        robot.run_until("shift-out", 5.0);
        assert!(robot.plant.driven_m - still_m < 0.001);
        let waited_s = (robot.plant.now_ns - began_ns) as f64 * 1e-9;
        assert!((waited_s - 2.0).abs() < 0.11, "{waited_s}");
        robot.run_until("on", 20.0);
        let pose = robot.plant.pose;
        assert!((pose.y_m + 0.5).abs() < 0.05, "seed {seed}: {pose:?}");
        robot.run_until("end", 20.0);
        assert!((robot.plant.pose.y_m + 0.5).abs() < 0.03);
        assert_eq!(robot.allocations, 0);
    }
}

/// East, U-turn, west; `side` +1 keeps right and turns left, −1 keeps left and turns right.
fn turning(side: f64) -> Floor {
    let direction = if side > 0.0 {
        TurnDirection::Left
    } else {
        TurnDirection::Right
    };
    let mut floor = corridor();
    for lane in &mut floor.site.lanes {
        lane.line.a.y_m *= side;
        lane.line.b.y_m *= side;
    }
    for area in &mut floor.site.areas {
        let (one, other) = (area.region.min.y_m * side, area.region.max.y_m * side);
        area.region.min.y_m = one.min(other);
        area.region.max.y_m = one.max(other);
    }
    let end = ControllerConfig::EndOfLane { distance_m: 1.2 };
    let turn = ControllerConfig::UTurn {
        direction,
        radius_m: 0.5,
    };
    floor
        .reached("near", [5.5, -1.6], [8.5, 1.6])
        .monitor("ended", MonitorKind::ManoeuvreDone)
        .monitor("turned", MonitorKind::ManoeuvreDone)
        .state("drive", "1", follow(0.0), &["near"])
        .state("end", "2", end, &["ended"])
        .searching_the_end()
        .state("turn", "3", turn, &["turned"])
        .state("back", "4", follow(0.0), &[])
        .go("drive", "near", "end")
        .go("end", "ended", "turn")
        .go("turn", "turned", "back")
}

#[test]
fn u_turns_to_both_sides_end_on_the_other_lane() {
    for side in [1.0, -1.0] {
        let floor = turning(side);
        for seed in 1..=SEEDS {
            let mut robot = floor.robot(seed, Pose2::new(5.0, -0.5 * side, 0.0));
            robot.run_until("turn", 30.0);
            let from_wall_m = 10.0 - robot.plant.pose.x_m;
            assert!((from_wall_m - 1.2).abs() < 0.05, "{from_wall_m}");
            let mut farthest_m: f64 = 0.0;
            while robot.state() == "turn" {
                robot.run_for(0.01);
                let pose = robot.plant.pose;
                farthest_m = farthest_m.max(pose.x_m);
                assert!(robot.plant.clearance_m() > 0.3, "seed {seed}: {pose:?}");
            }
            assert!((farthest_m - 9.3).abs() < 0.1, "{farthest_m}");
            robot.run_for(2.0);
            for _ in 0..20 {
                robot.run_for(0.1);
                let pose = robot.plant.pose;
                let off_m = pose.y_m - 0.5 * side;
                let off_rad = wrap_angle(pose.theta_rad - std::f64::consts::PI);
                assert!(
                    off_m.abs() < 0.03 && off_rad.abs() < 0.05,
                    "seed {seed}: {pose:?}"
                );
            }
            assert_eq!(robot.allocations, 0);
        }
    }
}

#[test]
fn another_navigator_takes_over_in_the_middle_of_a_turn() {
    let floor = turning(1.0);
    for after_s in [0.5, 2.0, 3.5] {
        let mut robot = floor.robot(2, Pose2::new(6.0, -0.5, 0.0));
        robot.run_until("turn", 30.0);
        robot.run_for(after_s);
        robot.motion_allowed = false;
        robot.run_for(1.0);
        let mut setup = floor.setup(Pose2::new(1.0, 1.0, 1.0));
        setup.gains.heading_gain_1_m = 4.5;
        let mut next = skills::navigator::Navigator::new(setup).unwrap();
        assert!(next.take_over(&robot.navigator));
        robot.navigator = next;
        robot.motion_allowed = true;
        let mut farthest_m: f64 = 0.0;
        while robot.state() == "turn" {
            robot.run_for(0.01);
            farthest_m = farthest_m.max(robot.plant.pose.x_m);
        }
        assert!(farthest_m < 9.4, "{farthest_m}");
        robot.run_for(3.0);
        let pose = robot.plant.pose;
        assert_eq!(robot.state(), "back");
        assert!((pose.y_m - 0.5).abs() < 0.04, "{after_s} s: {pose:?}");
    }
}

#[test]
fn a_slower_area_is_entered_at_its_speed_without_a_jump() {
    let mut floor = corridor();
    floor.site.areas[1].control.speed_limit_m_s = 0.15;
    let floor = floor
        .reached("in-2", [5.5, -0.9], [8.5, 0.0])
        .state("fast", "1", follow(0.0), &["in-2"])
        .state("slow", "2", follow(0.0), &[])
        .go("fast", "in-2", "slow");
    for seed in 1..=4 {
        let mut robot = floor.robot(seed, Pose2::new(3.5, -0.5, 0.0));
        robot.run_for(3.0);
        let mut before: Option<(u64, f64)> = None;
        let mut fastest_m_s: f64 = 0.0;
        for _ in 0..6000 {
            let Some(output) = robot.step() else { continue };
            let speed_m_s = output.command.speed_m_s;
            if output.pose.x_m < 5.0 {
                assert!(speed_m_s > 0.3, "{output:?}");
            }
            if output.pose.x_m > 5.5 {
                fastest_m_s = fastest_m_s.max(speed_m_s);
            }
            if let Some((before_ns, before_m_s)) = before {
                let dt_s = (output.now_ns - before_ns) as f64 * 1e-9;
                assert!(
                    before_m_s - speed_m_s <= 0.4 * dt_s + 1e-9,
                    "{before_m_s} {speed_m_s}"
                );
            }
            before = Some((output.now_ns, speed_m_s));
        }
        assert!(fastest_m_s < 0.17, "{fastest_m_s}");
        assert!((robot.output.unwrap().command.speed_m_s - 0.15).abs() < 0.002);
    }
}

#[test]
fn a_skill_may_be_slower_than_its_area() {
    let floor = corridor()
        .state("drive", "1", follow(0.0), &[])
        .at_speed(0.12);
    let mut robot = floor.robot(4, START);
    robot.run_for(5.0);
    let before_m = robot.plant.driven_m;
    robot.run_for(5.0);
    let speed_m_s = (robot.plant.driven_m - before_m) / 5.0;
    assert!((speed_m_s - 0.12).abs() < 0.005, "{speed_m_s}");
}

#[test]
fn where_nothing_is_in_view_for_long_it_stops_and_goes_on_when_walls_are_back() {
    let floor = corridor()
        .state("drive", "1", follow(0.0), &[])
        .tracking_only(&[Feature::Corridor]);
    let mut robot: Robot = floor.robot(5, START);
    robot.run_for(2.0);
    robot.trouble.codes = Some((0, 19));
    robot.run_for(4.0);
    let output = robot.output.unwrap();
    assert_eq!(output.hold, Some(skills::navigator::Hold::PoseUncertain));
    let stood_m = robot.plant.driven_m;
    robot.run_for(1.0);
    assert!(robot.plant.driven_m - stood_m < 1e-3);
    robot.trouble.codes = None;
    robot.run_for(3.0);
    assert!(robot.output.unwrap().hold.is_none() && robot.plant.driven_m > stood_m + 0.3);
}
