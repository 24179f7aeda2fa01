use super::*;
use description::areas::{AreaIndex, MAX_AREAS};
use description::geometry::{Footprint, MotionCommand, Point2, Pose2, Rect};
use nalgebra::{Matrix3, Vector3};
use proptest::prelude::*;

const FOOTPRINT: Footprint = Footprint {
    front_m: 0.32,
    rear_m: 0.08,
    left_m: 0.15,
    right_m: 0.15,
};
const EXACT: f64 = 1e-9;

fn rect(x0: f64, y0: f64, x1: f64, y1: f64) -> Rect {
    Rect::new(Point2::new(x0, y0), Point2::new(x1, y1))
}

fn guard(regions: &[Rect]) -> BorderGuard {
    BorderGuard::new(regions.iter().copied(), FOOTPRINT, BorderGains::default())
}

fn straight(reach_m: f64) -> Curve {
    Curve {
        curvature_1_m: 0.0,
        reach_m,
    }
}

fn known_to(x_m: f64, y_m: f64, theta_rad: f64) -> Matrix3<f64> {
    Matrix3::from_diagonal(&Vector3::new(x_m * x_m, y_m * y_m, theta_rad * theta_rad))
}

/// How deep two rectangles overlap, one of them turned; negative: apart. Independent of the guard's own reckoning.
fn overlap_m(footprint: &Footprint, pose: Pose2, region: &Rect) -> f64 {
    let corners = footprint.corners().map(|corner| pose.transform(corner));
    let others = [
        region.min,
        Point2::new(region.max.x_m, region.min.y_m),
        region.max,
        Point2::new(region.min.x_m, region.max.y_m),
    ];
    (0..4)
        .map(|quarter| {
            let angle = f64::from(quarter / 2) * pose.theta_rad
                + f64::from(quarter % 2) * std::f64::consts::FRAC_PI_2;
            let axis = Point2::new(angle.cos(), angle.sin());
            let span = |points: &[Point2; 4]| {
                points
                    .iter()
                    .map(|point| axis.dot(*point))
                    .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), at| {
                        (low.min(at), high.max(at))
                    })
            };
            let ((a, b), (c, d)) = (span(&corners), span(&others));
            (b - c).min(d - a)
        })
        .fold(f64::INFINITY, f64::min)
}

#[test]
fn a_set_holds_what_was_put_in() {
    let [a0, a3, a64, a255] = [0, 3, 64, 255].map(AreaIndex);
    let places = [3, 64, 255, 256, 1000];
    let mut set: AreaSet = places.into_iter().filter_map(AreaIndex::new).collect();
    assert_eq!(set.iter().collect::<Vec<_>>(), [a3, a64, a255]);
    assert!(!set.insert(a64) && set.insert(a0));
    assert!(set.remove(a3) && !set.remove(a3) && set.len() == 3);
    assert!(AreaIndex::new(MAX_AREAS).is_none() && AreaSet::ALL.contains(a255));
    assert!(AreaSet::EMPTY.is_empty() && AreaSet::ALL.len() == MAX_AREAS);
    let other: AreaSet = [0, 7].map(AreaIndex).into_iter().collect();
    assert_eq!(set.union(&other).len(), 4);
    assert_eq!(set.intersection(&other).iter().next(), Some(AreaIndex(0)));
    assert_eq!(set.difference(&other).len(), 2);
}

#[test]
fn the_front_stops_before_the_border_and_the_rear_when_backing() {
    let guard = guard(&[rect(2.0, -1.0, 4.0, 1.0), rect(-3.0, -1.0, -1.0, 1.0)]);
    let exact = known_to(EXACT, EXACT, EXACT);
    let ahead = guard.along_curve(&AreaSet::EMPTY, Pose2::IDENTITY, &exact, straight(5.0));
    assert_eq!((ahead.area, ahead.inside), (Some(AreaIndex(0)), false));
    assert!((1.66..=1.671).contains(&ahead.distance_m), "{ahead:?}");
    let behind = guard.along_curve(&AreaSet::EMPTY, Pose2::IDENTITY, &exact, straight(-5.0));
    assert_eq!(behind.area, Some(AreaIndex(1)));
    assert!((0.90..=0.911).contains(&behind.distance_m), "{behind:?}");
    let short = guard.along_curve(&AreaSet::EMPTY, Pose2::IDENTITY, &exact, straight(1.0));
    assert_eq!((short.area, short.distance_m), (None, 1.0));
    let with_leave: AreaSet = [AreaIndex(0)].into_iter().collect();
    let free = guard.along_curve(&with_leave, Pose2::IDENTITY, &exact, straight(5.0));
    assert_eq!(free.area, None);
}

#[test]
fn who_is_not_sure_stays_farther_away_but_only_in_that_direction() {
    let lane_beside = rect(0.0, 0.0, 10.0, 1.0);
    let lane_ahead = rect(6.0, -1.0, 10.0, 0.0);
    let guard = guard(&[lane_beside, lane_ahead]);
    let pose = Pose2::new(2.0, -0.5, 0.0);
    let along = known_to(0.2, 0.01, 0.005);
    let judged = guard.along_curve(&AreaSet::EMPTY, pose, &along, straight(5.0));
    assert_eq!(judged.area, Some(AreaIndex(1)));
    assert!(
        (judged.distance_m - (4.0 - 0.32 - 0.6 - 0.01)).abs() < 0.02,
        "{judged:?}"
    );
    let across = known_to(0.01, 0.2, 0.005);
    let judged = guard.along_curve(&AreaSet::EMPTY, pose, &across, straight(5.0));
    assert_eq!(
        (judged.area, judged.distance_m, judged.inside),
        (Some(AreaIndex(0)), 0.0, false)
    );
}

#[test]
fn a_curve_enters_where_the_outer_corner_does() {
    // A quarter turn to the left of radius 1: the front right corner swings out beyond 1.15 m.
    let guard = guard(&[rect(1.2, -1.0, 3.0, 3.0)]);
    let exact = known_to(EXACT, EXACT, EXACT);
    let curve = Curve {
        curvature_1_m: 1.0,
        reach_m: 1.5,
    };
    let judged = guard.along_curve(&AreaSet::EMPTY, Pose2::IDENTITY, &exact, curve);
    let corner = Point2::new(0.32, 1.0 + 0.15).norm_m();
    assert!(
        corner < 1.2 && judged.area.is_some() == (corner > 1.2 - 0.014),
        "{judged:?}"
    );
    let nearer = self::guard(&[rect(1.1, -1.0, 3.0, 3.0)]);
    let judged = nearer.along_curve(&AreaSet::EMPTY, Pose2::IDENTITY, &exact, curve);
    assert_eq!(judged.area, Some(AreaIndex(0)));
    let entry = Pose2::IDENTITY.advance(MotionCommand::new(1.0, 1.0).twist(), judged.distance_m);
    let depth_m = overlap_m(&FOOTPRINT, entry, &rect(1.1, -1.0, 3.0, 3.0));
    assert!((-0.016..=-0.009).contains(&depth_m), "{depth_m}");
}

#[test]
fn poses_are_followed_as_a_curve_is() {
    let region = rect(2.0, -1.0, 4.0, 1.0);
    let guard = guard(&[region]);
    let covariance = known_to(0.02, 0.01, 0.01);
    let curve = Curve {
        curvature_1_m: 0.2,
        reach_m: 4.0,
    };
    let pose = Pose2::new(0.1, -0.3, 0.1);
    let by_curve = guard.along_curve(&AreaSet::EMPTY, pose, &covariance, curve);
    let unit = MotionCommand::new(1.0, 0.2).twist();
    let poses = (1..=80).map(|step| pose.advance(unit, 0.05 * f64::from(step)));
    let by_poses = guard.along_poses(&AreaSet::EMPTY, pose, &covariance, poses);
    assert_eq!(by_curve.area, by_poses.area);
    assert!(
        (by_curve.distance_m - by_poses.distance_m).abs() < 0.01,
        "{by_curve:?} {by_poses:?}"
    );
    let nowhere = guard.along_poses(&AreaSet::EMPTY, pose, &covariance, []);
    assert_eq!((nowhere.area, nowhere.distance_m), (None, 0.0));
    // Turning on the spot swings the nose into the area, after no way at all.
    let beside = Pose2::new(1.8, 0.0, std::f64::consts::FRAC_PI_2);
    let turned = guard.along_poses(
        &AreaSet::EMPTY,
        beside,
        &known_to(EXACT, EXACT, EXACT),
        [Pose2::new(1.8, 0.0, 0.0)],
    );
    assert_eq!((turned.area, turned.distance_m), (Some(AreaIndex(0)), 0.0));
}

#[test]
fn who_is_inside_already_is_told_so_and_nonsense_stops() {
    let guard = guard(&[rect(2.0, -1.0, 4.0, 1.0)]);
    let exact = known_to(EXACT, EXACT, EXACT);
    let inside = Pose2::new(1.9, 0.0, 0.0);
    let judged = guard.along_curve(&AreaSet::EMPTY, inside, &exact, straight(1.0));
    assert_eq!(
        (judged.area, judged.inside, judged.distance_m),
        (Some(AreaIndex(0)), true, 0.0)
    );
    assert_eq!(judged.speed_limit_m_s(0.8, 0.1), 0.0);
    for pose in [
        Pose2::new(f64::NAN, 0.0, 0.0),
        Pose2::new(0.0, 0.0, f64::INFINITY),
    ] {
        let judged = guard.along_curve(&AreaSet::EMPTY, pose, &exact, straight(1.0));
        assert_eq!((judged.area, judged.distance_m), (Some(AreaIndex(0)), 0.0));
    }
    let broken = Matrix3::from_element(f64::NAN);
    let judged = guard.along_curve(&AreaSet::EMPTY, Pose2::IDENTITY, &broken, straight(1.0));
    assert_eq!((judged.area, judged.distance_m), (Some(AreaIndex(0)), 0.0));
}

#[test]
fn the_speed_limit_leaves_time_to_react_and_way_to_brake() {
    let at = |distance_m| BorderVerdict {
        distance_m,
        area: Some(AreaIndex(0)),
        inside: false,
    };
    for distance_m in [0.0, 0.01, 0.1, 1.0] {
        let v_m_s = at(distance_m).speed_limit_m_s(0.8, 0.15);
        assert!((v_m_s * 0.15 + v_m_s * v_m_s / 1.6 - distance_m).abs() < 1e-9);
    }
    let free = BorderVerdict {
        area: None,
        ..at(0.0)
    };
    assert_eq!(free.speed_limit_m_s(0.8, 0.1), f64::INFINITY);
}

/// Drives as navigation does: every 50 ms a speed that the limit allows, accelerating and braking no faster than it can.
#[test]
fn it_comes_to_rest_right_before_the_border() {
    let region = rect(3.0, -2.0, 5.0, 2.0);
    let guard = guard(&[region]);
    let (dt_s, deceleration_m_s2) = (0.05, 0.8);
    for (std_m, curvature_1_m, backward) in [
        (0.005, 0.0, false),
        (0.02, 0.3, false),
        (0.05, -0.2, false),
        (0.01, 0.0, true),
    ] {
        let covariance = known_to(std_m, std_m, 0.005);
        let sign = if backward { -1.0 } else { 1.0 };
        let heading_rad = if backward { std::f64::consts::PI } else { 0.0 };
        let mut pose = Pose2::new(0.0, 0.1, heading_rad);
        let mut speed_m_s = 0.0f64;
        for _ in 0..1000 {
            let curve = Curve {
                curvature_1_m,
                reach_m: sign * 1.0,
            };
            let judged = guard.along_curve(&AreaSet::EMPTY, pose, &covariance, curve);
            let limit_m_s = judged.speed_limit_m_s(deceleration_m_s2, 2.0 * dt_s);
            speed_m_s = (speed_m_s + 0.5 * dt_s)
                .min(0.4)
                .min(limit_m_s.max(speed_m_s - deceleration_m_s2 * dt_s));
            let twist = MotionCommand::new(sign * speed_m_s, curvature_1_m).twist();
            pose = pose.advance(twist, dt_s);
            assert!(overlap_m(&FOOTPRINT, pose, &region) < 0.0);
        }
        let gap_m = -overlap_m(&FOOTPRINT, pose, &region);
        let margin_m = 3.0 * (std_m * 1.5 + 0.005 * FOOTPRINT.radius_m()) + 0.01;
        assert!(
            speed_m_s < 0.01 && gap_m < margin_m + 0.03,
            "{gap_m} {margin_m}"
        );
        assert!(gap_m > 3.0 * std_m, "{gap_m}");
    }
}

/// A covariance with correlations, from standard deviations and three angles.
fn covariance() -> impl Strategy<Value = Matrix3<f64>> {
    (
        (0.001..0.08f64, 0.001..0.08f64, 0.001..0.06f64),
        (-3.0..3.0f64, -3.0..3.0f64, -3.0..3.0f64),
    )
        .prop_map(|((a, b, c), (x, y, z))| {
            let turn = nalgebra::Rotation3::from_euler_angles(x, y, z);
            let diagonal = Matrix3::from_diagonal(&Vector3::new(a * a, b * b, c * c));
            turn.matrix() * diagonal * turn.matrix().transpose()
        })
}

/// Inside or on the unit ball.
fn direction() -> impl Strategy<Value = Vector3<f64>> {
    (-1.0..1.0f64, -1.0..1.0f64, -1.0..1.0f64).prop_map(|(x, y, z)| {
        let vector = Vector3::new(x, y, z);
        if vector.norm() > 1.0 {
            vector.normalize()
        } else {
            vector
        }
    })
}

fn regions() -> impl Strategy<Value = Vec<Rect>> {
    prop::collection::vec(
        (-4.0..4.0f64, -4.0..4.0f64, 0.05..2.0f64, 0.05..2.0f64),
        1..6,
    )
    .prop_map(|all| {
        all.into_iter()
            .map(|(x, y, width, height)| rect(x, y, x + width, y + height))
            .collect()
    })
}

proptest! {
    /// Drives random curves as the guard allows, with a true pose anywhere in the three-sigma ellipsoid.
    #[test]
    fn no_part_of_the_footprint_ever_enters(
        regions in regions(),
        covariance in covariance(),
        error in direction(),
        curves in prop::collection::vec((-2.5..2.5f64, -1.0..1.5f64), 1..12),
    ) {
        let guard = guard(&regions);
        let mut estimate = Pose2::new(0.0, 0.0, 0.3);
        let judge = |estimate: Pose2, curve: Curve| guard.along_curve(&AreaSet::EMPTY, estimate, &covariance, curve);
        let start = judge(estimate, straight(0.0));
        prop_assume!(start.area.is_none());
        let offset = covariance.cholesky().expect("a covariance").l() * error * 3.0;
        for (curvature_1_m, reach_m) in curves {
            let curve = Curve { curvature_1_m, reach_m };
            let judged = judge(estimate, curve);
            prop_assert!(judged.distance_m <= reach_m.abs());
            let unit = MotionCommand::new(reach_m.signum(), curvature_1_m).twist();
            let steps = 40;
            for step in 0..=steps {
                let at = estimate.advance(unit, judged.distance_m * f64::from(step) / f64::from(steps));
                let truth = Pose2::new(at.x_m + offset.x, at.y_m + offset.y, at.theta_rad + offset.z);
                for region in &regions {
                    prop_assert!(overlap_m(&FOOTPRINT, truth, region) < 0.0, "{truth:?} in {region:?}");
                }
            }
            estimate = estimate.advance(unit, judged.distance_m);
        }
    }

    /// What stops it is really near: some pose in the ellipsoid, or a few millimetres, would touch.
    #[test]
    fn it_does_not_stop_far_from_what_is_forbidden(
        regions in regions(),
        stds in (0.001..0.02f64, 0.001..0.02f64, 0.001..0.02f64),
        curvature_1_m in -2.0..2.0f64,
        reach_m in -3.0..3.0f64,
    ) {
        let guard = guard(&regions);
        let covariance = known_to(stds.0, stds.1, stds.2);
        let judged = guard.along_curve(&AreaSet::EMPTY, Pose2::IDENTITY, &covariance, Curve { curvature_1_m, reach_m });
        let unit = MotionCommand::new(reach_m.signum(), curvature_1_m).twist();
        let end = Pose2::IDENTITY.advance(unit, judged.distance_m);
        if let Some(area) = judged.area {
            let depth_m = overlap_m(&FOOTPRINT, end, &regions[area.place()]);
            let margin_m = 3.0 * (stds.0.hypot(stds.1) + FOOTPRINT.radius_m() * stds.2) + 0.01;
            prop_assert!(depth_m > -margin_m - 0.01, "{depth_m} with a margin of {margin_m}");
        } else {
            prop_assert!((judged.distance_m - reach_m.abs()).abs() < 1e-12);
        }
    }

    #[test]
    fn nothing_that_comes_in_makes_it_panic(
        x in prop::num::f64::ANY, y in prop::num::f64::ANY, theta in prop::num::f64::ANY,
        entries in prop::array::uniform9(prop::num::f64::ANY),
        curvature_1_m in prop::num::f64::ANY, reach_m in prop::num::f64::ANY,
        regions in regions(),
    ) {
        let guard = guard(&regions);
        let covariance = Matrix3::from_row_slice(&entries);
        let pose = Pose2::new(x, y, theta);
        let judged = guard.along_curve(&AreaSet::EMPTY, pose, &covariance, Curve { curvature_1_m, reach_m });
        prop_assert!(judged.area.is_none() || judged.distance_m >= 0.0);
        let _ = guard.along_poses(&AreaSet::EMPTY, pose, &covariance, [Pose2::new(theta, x, y), pose]);
    }
}
