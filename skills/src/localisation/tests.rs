use super::doubt::{BLIND_SCANS, GOOD_SCANS, REFUSED_SCANS};
use super::*;
use crate::odometry::Odometry;
use crate::perception::WallFit;
use description::geometry::{Point2, Pose2, Segment, wrap_angle};
use description::robot::Navigation;
use nalgebra::Matrix2;
use proptest::prelude::*;

fn filter(pose: Pose2) -> PoseFilter {
    PoseFilter::new(Navigation::default(), pose, 0.1, 0.1)
}

fn odometry(x_m: f64, theta_rad: f64) -> Odometry {
    Odometry {
        stamp_ns: 1 + (x_m * 1e9) as u64,
        pose: Pose2::new(x_m, 0.0, theta_rad),
        distance_m: x_m,
        ..Odometry::default()
    }
}

/// What a perfect sensor at `truth` sees of a wall.
fn seen(line: &Segment, truth: Pose2) -> WallFit {
    WallFit {
        lateral_m: line.lateral_m(truth.position()),
        heading_rad: wrap_angle(truth.theta_rad - line.direction_rad()),
        covariance: Matrix2::new(1e-4, 0.0, 0.0, 1e-4),
        inliers: 100,
        share: 1.0,
        covered_m: 3.0,
        rms_m: 0.01,
    }
}

const NORTH: Segment = Segment::new(Point2::new(0.0, 1.6), Point2::new(10.0, 1.6));
const EAST: Segment = Segment::new(Point2::new(10.0, 1.6), Point2::new(10.0, -1.6));

#[test]
fn odometry_moves_it_and_makes_it_less_certain() {
    let mut filter = filter(Pose2::new(2.0, -0.5, 1.0));
    filter.predict(&odometry(0.0, 0.3));
    let before = filter.position_std_m();
    for step in 1..=100 {
        filter.predict(&odometry(0.02 * f64::from(step), 0.3));
    }
    let pose = filter.pose();
    let expected = Pose2::new(2.0, -0.5, 1.0)
        .compose(Pose2::new(0.0, 0.0, 0.3).between(Pose2::new(2.0, 0.0, 0.3)));
    assert!(
        pose.position().distance_m(expected.position()) < 1e-9,
        "{pose:?}"
    );
    assert!(filter.position_std_m() > before);
}

#[test]
fn two_walls_tell_the_whole_pose() {
    let truth = Pose2::new(8.1, -0.42, 0.08);
    let mut filter = filter(Pose2::new(8.0, -0.5, 0.0));
    for _ in 0..5 {
        assert!(filter.correct(&NORTH, &seen(&NORTH, truth)));
        assert!(filter.correct(&EAST, &seen(&EAST, truth)));
    }
    let pose = filter.pose();
    assert!(
        pose.position().distance_m(truth.position()) < 0.005,
        "{pose:?}"
    );
    assert!((pose.theta_rad - truth.theta_rad).abs() < 0.005);
    assert!(filter.position_std_m() < 0.01);
}

#[test]
fn one_wall_leaves_the_way_along_it_as_uncertain_as_it_was() {
    let truth = Pose2::new(5.0, -0.45, 0.0);
    let mut filter = filter(Pose2::new(5.3, -0.5, 0.0));
    filter.correct(&NORTH, &seen(&NORTH, truth));
    assert!((filter.std_along_m(0.0) - 0.1).abs() < 1e-3);
    assert!(filter.std_along_m(std::f64::consts::FRAC_PI_2) < 0.011);
    assert!((filter.pose().x_m - 5.3).abs() < 1e-3);
}

#[test]
fn improbable_walls_are_refused_and_end_in_doubt() {
    let mut filter = filter(Pose2::new(5.0, -0.5, 0.0));
    let elsewhere = seen(&NORTH, Pose2::new(5.0, 0.4, 0.0));
    assert!(!filter.correct(&NORTH, &elsewhere));
    assert_eq!(filter.pose(), Pose2::new(5.0, -0.5, 0.0));
    let nonsense = WallFit {
        lateral_m: f64::NAN,
        ..elsewhere
    };
    assert!(!filter.correct(&NORTH, &nonsense));
    assert_eq!(filter.counters().refused, 2);
    for _ in 0..REFUSED_SCANS {
        assert!(!filter.is_uncertain());
        filter.scan_done(ScanVerdict::Refused);
    }
    assert!(filter.is_uncertain());
    // The walls keep saying the same: in the end they are believed.
    let scans = (0..20).find(|_| {
        let accepted = filter.correct(&NORTH, &elsewhere);
        filter.scan_done(if accepted {
            ScanVerdict::Corrected
        } else {
            ScanVerdict::Refused
        });
        accepted
    });
    assert!(scans.is_some());
    assert!((filter.pose().y_m - 0.4).abs() < 0.1);
}

#[test]
fn blind_scans_end_in_doubt_and_a_wall_ends_the_doubt() {
    let truth = Pose2::new(5.0, -0.5, 0.0);
    let mut filter = filter(truth);
    for _ in 0..BLIND_SCANS {
        assert!(!filter.is_uncertain());
        filter.scan_done(ScanVerdict::Blind);
    }
    for _ in 0..GOOD_SCANS {
        assert!(filter.is_uncertain());
        assert!(filter.correct(&NORTH, &seen(&NORTH, truth)));
        filter.scan_done(ScanVerdict::Corrected);
    }
    assert!(!filter.is_uncertain());
}

#[test]
fn the_limits_have_hysteresis() {
    let mut filter = filter(Pose2::IDENTITY);
    filter.relocate(Pose2::IDENTITY, 0.31, 0.1);
    assert!(filter.is_uncertain());
    filter.covariance[(0, 0)] = 0.29 * 0.29;
    filter.covariance[(1, 1)] = 0.29 * 0.29;
    filter.judge();
    assert!(filter.is_uncertain());
    filter.relocate(Pose2::IDENTITY, 0.2, 0.1);
    assert!(!filter.is_uncertain());
}

#[test]
fn odometry_that_leaps_is_not_believed() {
    let mut filter = filter(Pose2::IDENTITY);
    filter.predict(&odometry(0.0, 0.0));
    filter.predict(&odometry(50.0, 0.0));
    let mut broken = odometry(50.01, 0.0);
    broken.pose.y_m = f64::NAN;
    filter.predict(&broken);
    filter.predict(&odometry(50.02, 0.0));
    assert!((filter.pose().x_m - 0.02).abs() < 1e-9);
    assert_eq!(filter.counters().odometry_leaps, 2);
}

proptest! {
    #[test]
    fn the_covariance_stays_one(
        steps in prop::collection::vec((0.0..0.5f64, -0.5..0.5f64, -0.3..0.3f64, any::<bool>()), 1..200),
    ) {
        let mut filter = filter(Pose2::new(5.0, 0.0, 0.0));
        let mut at = Odometry::default();
        for (way, turn, off, north) in steps {
            at.pose = at.pose.compose(Pose2::new(way, 0.0, turn));
            at.distance_m += way;
            at.turned_rad += turn.abs();
            at.stamp_ns += 100_000_000;
            filter.predict(&at);
            let wall = if north { NORTH } else { EAST };
            let pose = filter.pose();
            filter.correct(&wall, &seen(&wall, Pose2::new(pose.x_m + off, pose.y_m + off, pose.theta_rad + off / 3.0)));
            let covariance = filter.covariance();
            prop_assert!(filter.pose().is_finite());
            prop_assert!((covariance - covariance.transpose()).abs().max() < 1e-9);
            prop_assert!(covariance.symmetric_eigenvalues().min() > -1e-9);
        }
    }
}

#[test]
fn a_way_that_was_not_measured_makes_it_less_certain_by_more_than_driving() {
    let mut filter = filter(Pose2::new(2.0, -0.5, 1.0));
    filter.predict(&odometry(0.0, 0.3));
    let before = filter.position_std_m();
    let broken = Odometry {
        breaks: 1,
        ..odometry(0.01, 0.3)
    };
    filter.predict(&broken);
    assert!(filter.position_std_m() > before.hypot(0.09), "{before}");
    let once = filter.position_std_m();
    filter.predict(&Odometry {
        breaks: 1,
        ..odometry(0.02, 0.3)
    });
    assert!(filter.position_std_m() < once + 0.01);
}

/// In whatever direction: walls that agree may be others.
#[test]
fn a_way_of_which_only_the_length_is_known_is_doubted_by_it() {
    for way_m in [0.5, 3.0] {
        let mut filter = filter(Pose2::new(2.0, -0.5, 1.0));
        filter.predict(&odometry(0.0, 0.3));
        let moved = Odometry {
            breaks: 1,
            unmeasured_m: way_m,
            ..odometry(0.01, 0.3)
        };
        filter.predict(&moved);
        let found = (filter.position_std_m(), filter.heading_std_rad());
        assert!(found.0 > way_m && found.1 > way_m.min(3.0), "{found:?}");
        assert!(filter.is_uncertain());
        filter.predict(&moved);
        assert!(filter.position_std_m() < found.0 + 0.01);
    }
    // Nor does a step that is too long say more.
    let mut filter = filter(Pose2::IDENTITY);
    filter.predict(&odometry(0.0, 0.0));
    filter.predict(&Odometry {
        stamp_ns: 60_000_000_000,
        ..odometry(2.6, 0.0)
    });
    assert!(filter.position_std_m() > 2.6 && filter.is_uncertain());
}

#[test]
fn another_one_goes_on_from_what_odometry_has_moved_since() {
    let mut first = filter(Pose2::new(2.0, -0.5, 0.0));
    first.predict(&odometry(1.0, 0.0));
    let mut second = filter(Pose2::IDENTITY);
    second.resume(first.pose(), *first.covariance(), &first.odometry());
    second.predict(&odometry(1.25, 0.0));
    assert!((second.pose().x_m - 2.25).abs() < 1e-9 && !second.is_uncertain());
}

#[test]
fn way_that_may_not_have_been_driven_is_doubted_all_in_one_direction() {
    let mut filter = filter(Pose2::IDENTITY);
    let before = filter.position_std_m();
    for step in 0..=10 {
        filter.predict(&Odometry {
            slipped_m: 0.02 * f64::from(step),
            ..odometry(0.01 * f64::from(step), 0.0)
        });
    }
    let grown = filter.position_std_m() - before;
    assert!((0.2..0.21).contains(&grown), "{grown}");
}
