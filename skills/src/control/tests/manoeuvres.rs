//! The tracks of manoeuvres, and a point that follows them.

use std::f64::consts::{FRAC_PI_2, PI};

use description::geometry::{Point2, Pose2, Segment, wrap_angle};
use description::robot::Navigation;
use description::site::TurnDirection;

use super::{LANE, drive, follow};
use crate::control::manoeuvre::{self, Fillet};
use crate::control::*;

#[test]
fn u_turns_end_on_the_other_lane() {
    for (direction, side) in [(TurnDirection::Left, 1.0), (TurnDirection::Right, -1.0)] {
        // As wide as the circle, a little closer, and farther.
        for (apart_m, offset_m) in [(1.0, -0.08), (0.99, 0.0), (1.0, 0.08), (1.4, 0.0)] {
            let lateral_m: f64 = side * apart_m;
            let outgoing = Segment::new(Point2::new(8.0, lateral_m), Point2::new(0.0, lateral_m));
            let mut pose = Pose2::new(8.0, offset_m, 0.05);
            let track = manoeuvre::u_turn(direction, 0.5, 2.5, &LANE, &outgoing, pose).unwrap();
            assert!((track.max_curvature_1_m() - 2.0).abs() < 0.05);
            let worst_m = follow(Follower::new(track, Arrival::TURN), &mut pose, 0.3);
            assert!(worst_m < 0.11, "{worst_m}");
            assert!((pose.y_m - lateral_m).abs() < 0.1, "{pose:?}");
            assert!(wrap_angle(pose.theta_rad - PI).abs() < 0.16, "{pose:?}");
        }
    }
}

#[test]
fn a_turn_that_is_found_under_way_is_finished_and_not_begun_again() {
    for (side, apart_m) in [(1.0, 1.0), (-1.0, 1.0), (1.0, 1.6), (-1.0, 1.6)] {
        let direction = if side > 0.0 {
            TurnDirection::Left
        } else {
            TurnDirection::Right
        };
        let lateral_m = side * apart_m;
        let outgoing = Segment::new(Point2::new(8.0, lateral_m), Point2::new(0.0, lateral_m));
        let begin = Pose2::new(8.0, 0.0, 0.0);
        let whole = manoeuvre::u_turn(direction, 0.5, 2.5, &LANE, &outgoing, begin).unwrap();
        for share in 1..=9 {
            let mut pose = whole.pose_at(whole.length_m() * f64::from(share) / 10.0);
            pose.y_m += 0.03;
            let left = manoeuvre::u_turn(direction, 0.5, 2.5, &LANE, &outgoing, pose).unwrap();
            let rest_m = whole.length_m() * (1.0 - f64::from(share) / 10.0);
            assert!((left.length_m() - rest_m).abs() < 0.25, "{side} {share}");
            let mut most_m: f64 = 0.0;
            let mut follower = Follower::new(left, Arrival::TURN);
            while !follower.done() {
                let steer = follower.step(pose, 0.0, &Navigation::default());
                drive(&mut pose, steer.curvature_1_m, 0.3);
                most_m = most_m.max(pose.x_m);
            }
            // No farther out than the whole turn.
            assert!(most_m < 8.0 + 0.5 + 0.06, "{side} {share}: {most_m}");
            assert!(
                (pose.y_m - lateral_m).abs() < 0.1,
                "{side} {share}: {pose:?}"
            );
        }
    }
    let (onto, from) = (
        Segment::new(Point2::new(5.0, 0.0), Point2::new(5.0, 5.0)),
        Pose2::new(3.0, 0.0, 0.0),
    );
    let whole = manoeuvre::turn(0.8, 2.5, &LANE, &onto, from).unwrap();
    for along_m in [1.5, 1.8, 2.1] {
        let mut pose = whole.pose_at(along_m);
        pose.x_m -= 0.04;
        let left = manoeuvre::turn(0.8, 2.5, &LANE, &onto, pose).unwrap();
        let worst_m = follow(Follower::new(left, Arrival::TURN), &mut pose, 0.3);
        assert!(worst_m < 0.08, "{along_m}: {worst_m}");
        assert!((pose.x_m - 5.0).abs() < 0.1, "{along_m}: {pose:?}");
    }
}

#[test]
fn a_turn_that_has_ended_is_not_begun_again() {
    let outgoing = Segment::new(Point2::new(8.0, 1.0), Point2::new(0.0, 1.0));
    let onto = Segment::new(Point2::new(5.0, 0.0), Point2::new(5.0, 5.0));
    for over_rad in [-0.09, -0.05, 0.0, 0.05, 0.2] {
        let u_turn = |pose| {
            manoeuvre::u_turn(TurnDirection::Left, 0.5, 2.5, &LANE, &outgoing, pose).unwrap()
        };
        let mut pose = Pose2::new(8.0, 0.97, wrap_angle(PI + over_rad));
        let worst_m = follow(Follower::new(u_turn(pose), Arrival::TURN), &mut pose, 0.3);
        assert!(worst_m < 0.1, "{over_rad}: {worst_m}");
        let mut pose = Pose2::new(4.97, 1.0, FRAC_PI_2 + over_rad);
        let track = manoeuvre::turn(0.8, 2.5, &LANE, &onto, pose).unwrap();
        let worst_m = follow(Follower::new(track, Arrival::TURN), &mut pose, 0.3);
        assert!(worst_m < 0.1, "{over_rad}: {worst_m}");
    }
}

#[test]
fn a_junction_turn_joins_the_lanes_left_and_right() {
    for (end_y_m, turn_rad) in [(5.0, PI / 2.0), (-5.0, -PI / 2.0)] {
        let outgoing = Segment::new(Point2::new(5.0, 0.0), Point2::new(5.0, end_y_m));
        for (radius_m, start_m) in [(0.5, 2.0), (0.9, 4.5), (0.9, 4.2)] {
            let mut pose = Pose2::new(start_m, 0.02, 0.0);
            let track = manoeuvre::turn(radius_m, 2.5, &LANE, &outgoing, pose).unwrap();
            let along_m = track.length_m() - 0.3;
            assert!(track.curvature_1_m(along_m) * turn_rad > 0.0);
            let end = track.pose_at(track.length_m());
            assert!((end.x_m - 5.0).abs() < 1e-9, "{end:?}");
            assert!(wrap_angle(end.theta_rad - turn_rad).abs() < 1e-9);
            follow(Follower::new(track, Arrival::TURN), &mut pose, 0.3);
            assert!((pose.x_m - 5.0).abs() < 0.1, "{pose:?}");
        }
        let fillet = Fillet::between(&LANE, &outgoing, 0.7).unwrap().unwrap();
        assert!((fillet.tangent_m - 0.7).abs() < 1e-9 && (fillet.crossing_in_m - 5.0).abs() < 1e-9);
        assert!(fillet.check(&outgoing, 0.7).is_ok());
        let wide = Fillet::between(&LANE, &outgoing, 6.0).unwrap().unwrap();
        assert!(matches!(
            wide.check(&outgoing, 6.0),
            Err(TrackError::DoesNotFit {
                which: "before",
                ..
            })
        ));
    }
}

#[test]
fn straight_on_ends_where_it_would_have_wherever_it_is_begun_again() {
    let outgoing = Segment::new(Point2::new(12.4, 0.0), Point2::new(16.0, 0.0));
    for (begun_m, aside_m, end_m) in [
        (9.0, 0.05, 13.0),
        (10.0, 0.0, 14.0),
        (12.0, 0.02, 14.0),
        (13.9, 0.0, 14.1),
        // What cannot be corrected until there takes longer.
        (13.9, 0.1, 14.42),
        (15.0, 0.0, 15.2),
    ] {
        let pose = Pose2::new(begun_m, aside_m, 0.0);
        let track = manoeuvre::turn(1.0, 2.5, &LANE, &outgoing, pose).unwrap();
        let end = track.pose_at(track.length_m());
        assert!((end.x_m - end_m).abs() < 0.01, "{begun_m}: {end:?}");
    }
}

#[test]
fn straight_on_at_a_junction_is_a_shift() {
    let outgoing = Segment::new(Point2::new(6.0, 0.1), Point2::new(12.0, 0.1));
    let mut pose = Pose2::new(4.0, 0.0, 0.0);
    let track = manoeuvre::turn(0.5, 2.5, &LANE, &outgoing, pose).unwrap();
    follow(Follower::new(track, Arrival::TURN), &mut pose, 0.4);
    assert!(
        (pose.y_m - 0.1).abs() < 0.03 && pose.theta_rad.abs() < 0.1,
        "{pose:?}"
    );
}

#[test]
fn a_shift_reaches_the_lane_beside_within_its_length() {
    for (offset_m, heading_rad) in [(0.0, 0.0), (0.0, 0.15), (0.1, -0.15)] {
        for lateral_m in [-0.7, 0.7] {
            let mut pose = Pose2::new(1.0, lateral_m, heading_rad);
            let track = manoeuvre::shift(&LANE, offset_m, 1.6, 2.5, pose).unwrap();
            assert!((track.length_m() - 1.6).abs() < 1e-9);
            assert!(
                track.max_curvature_1_m() < 2.5,
                "{}",
                track.max_curvature_1_m()
            );
            let start = track.pose_at(0.0);
            assert!(start.between(pose).position().norm_m() < 1e-9);
            assert!((start.theta_rad - heading_rad).abs() < 1e-9);
            let worst_m = follow(Follower::new(track, Arrival::SHIFT), &mut pose, 0.3);
            assert!(worst_m < 0.02, "{worst_m}");
            assert!((pose.y_m - offset_m).abs() < 0.03, "{pose:?}");
            assert!((pose.x_m - 2.6).abs() < 0.1, "{pose:?}");
        }
    }
}

#[test]
fn a_shift_that_is_found_under_way_is_finished_and_does_not_lead_beyond_the_lane() {
    for lateral_m in [-0.75, 0.75] {
        let begin = Pose2::new(1.0, lateral_m, 0.0);
        let whole = manoeuvre::shift(&LANE, 0.0, 1.5, 2.5, begin).unwrap();
        for along_m in [0.3, 0.7, 1.0, 1.2, 1.3, 1.4] {
            let mut pose = whole.pose_at(along_m);
            let rest = manoeuvre::shift(&LANE, 0.0, 1.5, 2.5, pose).unwrap();
            assert!(rest.max_curvature_1_m() < 2.5 && rest.length_m() <= 1.5 + 1e-9);
            let samples = (0..=40).map(|sample| f64::from(sample) / 40.0 * rest.length_m());
            let beyond_m = samples.map(|at_m| -rest.pose_at(at_m).y_m * lateral_m.signum());
            let beyond_m = beyond_m.fold(0.0, f64::max);
            assert!(beyond_m < 0.012, "{lateral_m} {along_m}: {beyond_m}");
            follow(Follower::new(rest, Arrival::SHIFT), &mut pose, 0.2);
            assert!(pose.y_m.abs() < 0.03, "{lateral_m} {along_m}: {pose:?}");
        }
    }
}

#[test]
fn what_cannot_be_driven_is_refused() {
    let back =
        |lateral_m: f64| Segment::new(Point2::new(8.0, lateral_m), Point2::new(0.0, lateral_m));
    let from = Pose2::new(8.0, 0.0, 0.0);
    let u_turn =
        |outgoing| manoeuvre::u_turn(TurnDirection::Left, 0.5, 2.5, &LANE, &outgoing, from);
    assert!(matches!(
        u_turn(back(0.9)),
        Err(TrackError::TooClose { .. })
    ));
    assert!(matches!(
        u_turn(back(-1.0)),
        Err(TrackError::TooClose { .. })
    ));
    assert!(matches!(u_turn(LANE), Err(TrackError::NotBack { .. })));
    assert!(manoeuvre::check_shift(0.7, 1.0, 2.5).is_err());
    assert!(manoeuvre::check_shift(0.7, 1.45, 2.5).is_ok());
    let pose = Pose2::new(1.0, 0.0, 2.0);
    assert!(manoeuvre::shift(&LANE, 0.0, 1.0, 2.5, pose).is_err());
    assert!(manoeuvre::turn(0.5, 2.5, &LANE, &back(1.0), pose).is_err());
}

#[test]
fn a_track_that_is_left_leads_back() {
    let gains = Navigation::default();
    let outgoing = Segment::new(Point2::new(5.0, 0.0), Point2::new(5.0, 5.0));
    let mut pose = Pose2::new(3.0, 0.0, 0.0);
    let track = manoeuvre::turn(0.6, 2.5, &LANE, &outgoing, pose).unwrap();
    let mut follower = Follower::new(track, Arrival::TURN);
    for step in 0..2000 {
        let steer = follower.step(pose, 0.3, &gains);
        drive(&mut pose, steer.curvature_1_m, 0.3);
        if step % 60 == 59 && step < 240 {
            pose = pose.compose(Pose2::new(0.0, 0.1, 0.1));
        }
        if follower.done() {
            return;
        }
    }
    panic!("never done, at {pose:?}");
}
