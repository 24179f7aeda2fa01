//! Tests of the plane geometry.

use super::*;
use proptest::prelude::*;
use std::f64::consts::{FRAC_PI_2, PI, TAU};

fn pose() -> impl Strategy<Value = Pose2> {
    (-10.0..10.0, -10.0..10.0, -PI..PI).prop_map(|(x, y, t)| Pose2::new(x, y, t))
}

fn close(one: Pose2, other: Pose2) -> bool {
    one.position().distance_m(other.position()) < 1e-9
        && wrap_angle(one.theta_rad - other.theta_rad).abs() < 1e-9
}

proptest! {
    #[test]
    fn a_pose_and_its_inverse_cancel(one in pose(), other in pose()) {
        prop_assert!(close(one.compose(one.inverse()), Pose2::IDENTITY));
        prop_assert!(close(one.compose(one.between(other)), other));
        let point = other.position();
        prop_assert!(one.inverse_transform(one.transform(point)).distance_m(point) < 1e-9);
    }

    #[test]
    fn wrapping_keeps_the_direction(angle in -100.0..100.0f64) {
        let wrapped = wrap_angle(angle);
        prop_assert!(wrapped > -PI && wrapped <= PI);
        prop_assert!((wrapped.sin() - angle.sin()).abs() < 1e-9);
        prop_assert!((wrapped.cos() - angle.cos()).abs() < 1e-9);
    }

    #[test]
    fn two_half_displacements_make_a_whole(v in -1.0..1.0f64, omega in -2.0..2.0f64, t in 0.0..4.0f64) {
        let twist = Twist2::new(v, omega);
        let half = twist.displacement(t / 2.0);
        let whole = twist.displacement(t);
        prop_assert!(half.compose(half).position().distance_m(whole.position()) < 1e-7);
    }
}

#[test]
fn a_quarter_circle_ends_where_it_should() {
    let end = Twist2::new(0.5, 0.5).displacement(TAU);
    assert!(end.position().distance_m(Point2::new(0.0, 2.0)) < 1e-12);
    let end = MotionCommand::new(0.25, 2.0)
        .twist()
        .displacement(FRAC_PI_2 / 0.5);
    assert!(close(end, Pose2::new(0.5, 0.5, FRAC_PI_2)));
}

#[test]
fn a_segment_measures_along_left_and_by_ray() {
    let wall = Segment::new(Point2::new(0.0, 1.0), Point2::new(4.0, 1.0));
    assert_eq!(wall.along_m(Point2::new(3.0, 5.0)), 3.0);
    assert_eq!(wall.lateral_m(Point2::new(3.0, 5.0)), 4.0);
    assert_eq!(wall.distance_m(Point2::new(7.0, 5.0)), 5.0);
    let range = wall.ray_range_m(Point2::new(2.0, 0.0), FRAC_PI_2);
    assert!((range.unwrap() - 1.0).abs() < 1e-12);
    assert_eq!(wall.ray_range_m(Point2::new(2.0, 0.0), 0.0), None);
    assert_eq!(wall.ray_range_m(Point2::new(2.0, 0.0), -FRAC_PI_2), None);
}

#[test]
fn an_empty_segment_divides_by_nothing() {
    let point = Segment::default();
    assert_eq!(point.distance_m(Point2::new(3.0, 4.0)), 5.0);
    assert_eq!(point.lateral_m(Point2::new(3.0, 4.0)), 0.0);
}

#[test]
fn a_footprint_measures_outwards() {
    let footprint = Footprint {
        front_m: 0.32,
        rear_m: 0.08,
        left_m: 0.15,
        right_m: 0.15,
    };
    assert!(footprint.contains(Point2::new(0.3, -0.1)));
    assert!((footprint.distance_m(Point2::new(0.42, 0.0)) - 0.1).abs() < 1e-12);
    assert!((footprint.length_m() - 0.4).abs() < 1e-12);
    assert!(
        !Footprint {
            rear_m: f64::NAN,
            ..footprint
        }
        .is_valid()
    );
}

#[test]
fn what_is_not_finite_stays_visible() {
    assert!(wrap_angle(f64::NAN).is_nan());
    assert!(!MotionCommand::new(f64::INFINITY, 0.0).is_finite());
    assert!(!Pose2::new(0.0, f64::NAN, 0.0).is_finite());
}
