use super::*;
use crate::geometry::{Point2, Pose2, Segment};
use std::f64::consts::PI;

const LANE: Segment = Segment::new(Point2::new(0.0, 0.0), Point2::new(10.0, 0.0));

/// Drives a point that follows its command at once.
fn drive(pose: &mut Pose2, command: MotionCommand, dt_s: f64) {
    *pose = pose.advance(command.twist(), dt_s);
}

#[test]
fn the_law_leads_back_from_everywhere_without_overshoot() {
    let gains = ControlGains::default();
    for lateral_m in [-2.0, -0.3, 0.05, 0.8] {
        for heading_rad in [-1.2, 0.0, 0.9] {
            let mut pose = Pose2::new(0.0, lateral_m, heading_rad);
            // Far off the lane it creeps.
            for _ in 0..5000 {
                let error = PathError {
                    lateral_m: pose.y_m,
                    heading_rad: pose.theta_rad,
                };
                let output = Corridor.step(error, 0.4, &gains);
                assert!(output.command.curvature_1_m.abs() <= gains.max_curvature_1_m);
                assert!(output.command.speed_m_s > 0.1 && output.command.speed_m_s <= 0.4);
                drive(&mut pose, output.command, 0.01);
                if heading_rad == 0.0 {
                    assert!(pose.y_m * lateral_m.signum() > -0.01, "{pose:?}");
                }
            }
            assert!(
                pose.y_m.abs() < 0.005 && pose.theta_rad.abs() < 0.01,
                "{pose:?}"
            );
        }
    }
}

#[test]
fn at_the_lanes_end_it_has_the_exit_speed() {
    let gains = ControlGains::default();
    let end = EndOfLane {
        distance_m: 1.2,
        exit_speed_m_s: 0.3,
    };
    let (mut wall_m, mut speed_m_s) = (4.0, 0.4);
    for _ in 0..2000 {
        let output = end.step(PathError::default(), wall_m, 0.4, speed_m_s, &gains);
        if output.done {
            break;
        }
        assert!(output.command.speed_m_s <= 0.4);
        speed_m_s = output.command.speed_m_s;
        wall_m -= speed_m_s * 0.01;
    }
    assert!((1.2..1.25).contains(&wall_m), "{wall_m}");
    assert!((speed_m_s - 0.3).abs() < 0.05, "{speed_m_s}");
}

#[test]
fn told_to_stop_at_the_end_it_stops_there() {
    let gains = ControlGains::default();
    let end = EndOfLane {
        distance_m: 0.3,
        exit_speed_m_s: 0.0,
    };
    let mut wall_m = 2.0;
    let mut steps = 0;
    loop {
        let output = end.step(PathError::default(), wall_m, 0.4, 0.2, &gains);
        if output.done {
            assert_eq!(output.command.speed_m_s, 0.0);
            break;
        }
        wall_m -= output.command.speed_m_s * 0.01;
        steps += 1;
        assert!(steps < 5000);
    }
    assert!((wall_m - 0.3).abs() <= 0.011, "{wall_m}");
    let beyond = end.step(PathError::default(), 0.1, 0.4, 0.0, &gains);
    assert!(beyond.done && beyond.command.speed_m_s == 0.0);
}

#[test]
fn a_u_turn_ends_on_the_other_lane() {
    let gains = ControlGains::default();
    for (direction, side) in [(TurnDirection::Left, 1.0), (TurnDirection::Right, -1.0)] {
        for offset_m in [-0.08, 0.0, 0.08] {
            let outgoing = Segment::new(Point2::new(8.0, side), Point2::new(0.0, side));
            let mut pose = Pose2::new(8.0, offset_m, 0.05);
            let mut turn = UTurn::start(direction, 0.5, Some(&LANE), &outgoing, pose);
            let mut farthest_m: f64 = 0.0;
            let mut done = false;
            for _ in 0..1000 {
                let output = turn.step(pose, 0.3, 0.3, &gains);
                assert_eq!(output.command.speed_m_s, 0.3);
                if output.done {
                    done = true;
                    break;
                }
                drive(&mut pose, output.command, 0.02);
                farthest_m = farthest_m.max(pose.x_m);
            }
            assert!(done, "{pose:?}");
            assert!((farthest_m - 8.5).abs() < 0.1, "{farthest_m}");
            assert!((pose.y_m - side).abs() < 0.1, "{pose:?}");
            assert!(wrap(pose.theta_rad - PI) < 0.16, "{pose:?}");
        }
    }
}

fn wrap(angle_rad: f64) -> f64 {
    crate::geometry::wrap_angle(angle_rad).abs()
}

#[test]
fn a_u_turn_onto_a_lane_farther_off_drives_on_until_it_is_there() {
    let gains = ControlGains::default();
    let outgoing = Segment::new(Point2::new(8.0, 1.4), Point2::new(0.0, 1.4));
    let mut pose = Pose2::new(8.0, 0.0, 0.0);
    let mut turn = UTurn::start(TurnDirection::Left, 0.5, Some(&LANE), &outgoing, pose);
    let steps = (0..2000).find(|_| {
        let output = turn.step(pose, 0.3, 0.3, &gains);
        drive(&mut pose, output.command, 0.02);
        output.done
    });
    assert!(steps.is_some() && (pose.y_m - 1.4).abs() < 0.26, "{pose:?}");
}
