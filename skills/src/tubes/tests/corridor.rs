//! Usefulness: in the empty reference corridor nothing that is needed is declared blocked.

use super::stand::{parameters, with_detours, without_detours};
use super::world::{Drive, MS, Random, Robot, SMALL, corridor, urg};
use crate::tubes::{MotionTubes, Reason, StopRules, TubeSet, Verdict};
use description::geometry::{MotionCommand, Pose2, wrap_angle};
use description::robot::Tubes;
use std::f64::consts::PI;

fn tubes(augment_m: f64) -> MotionTubes {
    let parameters = Tubes {
        augment_m,
        ..parameters()
    };
    let (set, _) = TubeSet::generate(&parameters, &SMALL, &urg()).unwrap();
    MotionTubes::new(set, with_detours(), StopRules::default()).unwrap()
}

/// Follows a lane: y, direction of travel.
fn follow(pose: Pose2, lane_y_m: f64, heading_rad: f64) -> MotionCommand {
    let along = if heading_rad == 0.0 { 1.0 } else { -1.0 };
    let lateral_m = along * (pose.y_m - lane_y_m);
    let heading_error_rad = wrap_angle(pose.theta_rad - heading_rad);
    MotionCommand::new(0.4, -4.0 * lateral_m - 3.0 * heading_error_rad)
}

/// Drives two laps of the corridor; gives the verdicts while driving, by phase.
fn laps(noise_m: f64, augment_m: f64) -> Vec<(bool, Verdict, Reason, f64)> {
    let walls = corridor();
    let mut drive = Drive::new(
        Robot::new(Pose2::new(2.0, -0.5, 0.0), urg()),
        tubes(augment_m),
    );
    drive.noise_m = noise_m;
    drive.random = Random(5);
    for _ in 0..22 {
        drive.tick(&walls, MotionCommand::STOP);
    }
    let mut verdicts = Vec::new();
    let mut u_turn: Option<f64> = None;
    let mut turns = 0;
    for _ in 0..2_000 {
        let pose = drive.robot.pose;
        let east = turns % 2 == 0;
        let (lane_y_m, heading_rad) = if east { (-0.5, 0.0) } else { (0.5, PI) };
        let wall_ahead_m = if east { 10.0 - pose.x_m } else { pose.x_m };
        let wanted = match u_turn {
            None if wall_ahead_m <= 1.2 => {
                u_turn = Some(wrap_angle(heading_rad + PI));
                MotionCommand::new(0.3, 2.0)
            }
            None => follow(pose, lane_y_m, heading_rad),
            Some(goal_rad) if wrap_angle(goal_rad - pose.theta_rad).abs() < 0.05 => {
                u_turn = None;
                turns += 1;
                continue;
            }
            Some(_) => MotionCommand::new(0.3, 2.0),
        };
        let adapted = drive.tick(&walls, wanted);
        verdicts.push((
            u_turn.is_some(),
            adapted.verdict,
            adapted.reason,
            wall_ahead_m,
        ));
        let touches = walls
            .iter()
            .any(|wall| wall.overlaps(&SMALL, drive.robot.pose));
        assert!(!touches, "a wall is touched at {:?}", drive.robot.pose);
        if turns == 4 {
            return verdicts;
        }
    }
    panic!("two laps take too long, {turns} turns");
}

#[test]
fn lanes_and_u_turns_of_the_empty_corridor_are_free() {
    for (noise_m, augment_m) in [(0.0, 0.045), (0.01, 0.045), (0.01, 0.06)] {
        for (in_u_turn, verdict, reason, wall_ahead_m) in laps(noise_m, augment_m) {
            let needed = in_u_turn || wall_ahead_m > 2.4;
            if needed {
                assert_eq!(
                    verdict,
                    Verdict::Free,
                    "{reason:?}, wall {wall_ahead_m:.2} m ahead, U-turn {in_u_turn}, noise {noise_m}"
                );
            } else {
                // The wall ahead shortens the horizon: slower, on the lane, and never a stop.
                assert!(
                    matches!(verdict, Verdict::Free | Verdict::Slowed),
                    "{verdict:?} {reason:?}, wall {wall_ahead_m:.2} m ahead, noise {noise_m}"
                );
            }
        }
    }
}

#[test]
fn towards_a_wall_it_slows_step_by_step_and_stops_before_it() {
    let walls = corridor();
    let set = tubes(0.045).set().clone();
    let tubes = MotionTubes::new(set, without_detours(), StopRules::default()).unwrap();
    let mut drive = Drive::new(Robot::new(Pose2::new(6.0, -0.5, 0.0), urg()), tubes);
    let mut speeds = Vec::new();
    for _ in 0..300 {
        let adapted = drive.tick(&walls, MotionCommand::new(0.4, 0.0));
        if adapted.verdict != Verdict::Stopped {
            speeds.push((
                10.0 - 0.32 - drive.robot.pose.x_m,
                adapted.command.speed_m_s,
            ));
        }
    }
    let allowed_at = |gap_m: f64| {
        speeds
            .iter()
            .min_by(|a, b| (a.0 - gap_m).abs().total_cmp(&(b.0 - gap_m).abs()))
            .unwrap()
            .1
    };
    assert_eq!(allowed_at(2.0), 0.4);
    assert_eq!(allowed_at(1.3), 0.35);
    assert_eq!(allowed_at(0.9), 0.3);
    assert_eq!(allowed_at(0.5), 0.25);
    let gap_m = 10.0 - 0.32 - drive.robot.pose.x_m;
    assert!(
        (0.1..0.35).contains(&gap_m),
        "stands {gap_m} m before the wall"
    );
    let counters = drive.tubes.counters();
    assert_eq!(counters.blocked_stops, 1);
    assert!(drive.robot.now_ns > 10_000 * MS);
}
