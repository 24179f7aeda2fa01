//! The law, speeds at ends of lanes, stops; and in a part of its own the tracks of manoeuvres.

mod manoeuvres;

use super::*;
use description::geometry::{MotionCommand, Point2, Pose2, Segment};
use description::robot::Navigation;

const LANE: Segment = Segment::new(Point2::new(0.0, 0.0), Point2::new(10.0, 0.0));
const DT_S: f64 = 0.02;

/// Drives a point that follows its command at once.
fn drive(pose: &mut Pose2, curvature_1_m: f64, speed_m_s: f64) {
    let command = MotionCommand::new(speed_m_s, curvature_1_m);
    *pose = pose.advance(command.twist(), DT_S);
}

fn on_lane(pose: Pose2) -> PathError {
    PathError {
        lateral_m: pose.y_m,
        heading_rad: pose.theta_rad,
    }
}

#[test]
fn the_law_leads_back_from_everywhere_without_overshoot() {
    let gains = Navigation::default();
    for lateral_m in [-2.0, -0.3, 0.05, 0.8] {
        for heading_rad in [-1.2, 0.0, 0.9] {
            let mut pose = Pose2::new(0.0, lateral_m, heading_rad);
            for _ in 0..3000 {
                let steer = keep_lane(on_lane(pose), &gains);
                assert!(steer.curvature_1_m.abs() <= gains.max_curvature_1_m);
                assert!(steer.speed_share > 0.25 && steer.speed_share <= 1.0);
                // Far off the lane it creeps.
                drive(&mut pose, steer.curvature_1_m, 0.4 * steer.speed_share);
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
fn backward_the_same_gains_need_the_other_law() {
    let gains = Navigation::default();
    for lateral_m in [-0.2, 0.0, 0.1] {
        for heading_rad in [-0.2, 0.0, 0.3] {
            let mut pose = Pose2::new(0.0, lateral_m, heading_rad);
            let mut worst_m: f64 = 0.0;
            for _ in 0..2000 {
                let curvature_1_m = reverse_curvature(on_lane(pose), &gains);
                drive(&mut pose, curvature_1_m, -0.1);
                worst_m = worst_m.max(pose.y_m.abs());
            }
            assert!(
                pose.y_m.abs() < 0.005 && pose.theta_rad.abs() < 0.01,
                "{pose:?}"
            );
            assert!(worst_m < lateral_m.abs() + 0.1, "{worst_m}");
        }
    }
    // The law of forward motion lets the smallest error grow.
    let mut pose = Pose2::new(0.0, 0.01, 0.0);
    for _ in 0..2000 {
        let curvature_1_m = path_curvature(on_lane(pose), 0.0, &gains);
        drive(&mut pose, curvature_1_m, -0.1);
    }
    assert!(pose.y_m.abs() > 0.1, "{pose:?}");
}

#[test]
fn a_creep_measures_its_way_in_both_directions() {
    let gains = Navigation::default();
    for distance_m in [-0.4, 0.3] {
        let start = Pose2::new(1.0, 2.0, 0.52);
        let creep = Creep::start(start, 0.5, distance_m);
        let mut pose = start;
        assert!((creep.left_m(pose) - distance_m.abs()).abs() < 1e-9);
        while creep.left_m(pose) > 0.0 {
            let steer = creep.step(pose, &gains);
            assert_eq!(steer.direction, distance_m.signum());
            drive(&mut pose, steer.curvature_1_m, 0.1 * steer.direction);
        }
        let moved = Pose2::new(1.0, 2.0, 0.5).between(pose);
        assert!((moved.x_m - distance_m).abs() < 0.003, "{moved:?}");
        assert!(moved.y_m.abs() < 0.01 && moved.theta_rad.abs() < 0.02);
    }
}

#[test]
fn at_the_lanes_end_it_has_the_exit_speed() {
    let gains = Navigation::default();
    let end = EndOfLane {
        distance_m: 1.2,
        exit_speed_m_s: 0.3,
    };
    let (mut wall_m, mut speed_m_s) = (4.0, 0.4f64);
    for _ in 0..2000 {
        let (allowed_m_s, done) = end.step(wall_m, 0.4, speed_m_s, &gains);
        if done {
            break;
        }
        speed_m_s = allowed_m_s.min(0.4);
        wall_m -= speed_m_s * 0.01;
    }
    assert!((1.2..1.25).contains(&wall_m), "{wall_m}");
    assert!((speed_m_s - 0.3).abs() < 0.05, "{speed_m_s}");
}

#[test]
fn told_to_stop_at_the_end_it_stops_there() {
    let gains = Navigation::default();
    let end = EndOfLane {
        distance_m: 0.3,
        exit_speed_m_s: 0.0,
    };
    let mut wall_m = 2.0;
    let mut steps = 0;
    loop {
        let (allowed_m_s, done) = end.step(wall_m, 0.4, 0.2, &gains);
        if done {
            assert_eq!(allowed_m_s, 0.0);
            break;
        }
        wall_m -= allowed_m_s.min(0.4) * 0.01;
        steps += 1;
        assert!(steps < 5000);
    }
    assert!((wall_m - 0.3).abs() <= 0.011, "{wall_m}");
    assert_eq!(end.step(0.1, 0.4, 0.0, &gains), (0.0, true));
}

#[test]
fn stopping_ends_at_the_place_and_tries_again_while_the_place_moves() {
    let mut stopping = Stopping::default();
    let (mut left_m, mut speed_m_s) = (1.0, 0.4f64);
    let mut moved = false;
    for step in 0..4000 {
        let wanted_m_s = stopping.speed_m_s(left_m, speed_m_s, 0.4, 0.01).min(0.4);
        // The wheels follow with a lag.
        speed_m_s += (wanted_m_s - speed_m_s).clamp(-0.008, 0.005);
        left_m -= speed_m_s * 0.01;
        if !moved && speed_m_s < 1e-3 && step > 100 {
            moved = true;
            left_m += 0.02;
        }
        if stopping.arrived() {
            break;
        }
    }
    assert!(
        moved && stopping.arrived() && left_m.abs() < 0.008,
        "{left_m}"
    );
    assert_eq!(stopping.speed_m_s(0.5, 0.0, 0.4, 0.01), 0.0);
    let mut hostile = Stopping::default();
    assert_eq!(hostile.speed_m_s(f64::NAN, f64::NAN, 0.4, 0.01), 0.0);
}

/// Follows a track from `pose`; the pose at the end, and the largest error on the way.
fn follow(mut follower: Follower, pose: &mut Pose2, speed_m_s: f64) -> f64 {
    let gains = Navigation::default();
    let mut worst_m: f64 = 0.0;
    for _ in 0..2000 {
        let steer = follower.step(*pose, 0.0, &gains);
        if follower.done() {
            return worst_m;
        }
        drive(pose, steer.curvature_1_m, speed_m_s);
        worst_m = worst_m.max(steer.error.lateral_m.abs());
    }
    panic!("never done, at {pose:?}");
}
