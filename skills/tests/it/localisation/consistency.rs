//! Whether the covariance is honest: the true error against what it claims.

use crate::localisation::floor::{Floor, Vehicle};
use crate::localisation::maps::{self, Place};
use crate::localisation::run::Drive;
use crate::random::Random;
use description::geometry::{Pose2, Twist2, wrap_angle};
use description::robot::Navigation;
use skills::localisation::PoseFilter;

/// Average and largest normalised error squared (three degrees of freedom) and its share above 11.3 (one per cent).
fn nees(place: &Place, seeds: std::ops::Range<u64>) -> (f64, f64, f64) {
    let (mut count, mut sum, mut worst, mut beyond) = (0.0, 0.0, 0.0f64, 0.0);
    for seed in seeds {
        let mut drive = Drive::honest(seed, place, Floor::of(place.walls()));
        while let Some(sample) = drive.next() {
            let nees = sample.nees();
            count += 1.0;
            sum += nees;
            worst = worst.max(nees);
            beyond += f64::from(u8::from(nees > 11.3));
        }
    }
    (sum / count, worst, beyond / count)
}

#[test]
fn the_error_stays_within_what_the_covariance_claims() {
    for (place, seeds) in [
        (maps::corridor(), 100..101),
        (maps::t_junction(), 110..111),
        (maps::pieces(), 120..122),
    ] {
        let (mean, worst, beyond) = nees(&place, seeds);
        // An average of three would be exact and less is careful; close to 0 the covariance would be far too large.
        assert!((0.15..3.0).contains(&mean), "{mean}");
        assert!(worst < 25.0 && beyond < 0.01, "{worst} {beyond}");
    }
}

/// Dead reckoning alone, over distances after which the pose is not yet uncertain.
#[test]
fn dead_reckoning_is_no_better_than_it_claims() {
    let (mut sum, mut beyond) = (0.0, 0.0);
    let runs = 200;
    for seed in 0..runs {
        let start = Pose2::new(1.0, 2.0, 0.5);
        let mut vehicle = Vehicle::new(seed, Floor::default(), start);
        let mut filter = PoseFilter::new(Navigation::default(), start, 0.01, 0.01);
        filter.predict(&vehicle.odometry);
        let mut random = Random::new(seed + 5000);
        let metres = random.between(0.5, 8.0);
        let mut turning = 0.0;
        for step in 0..(metres / 0.004) as u32 {
            if step.is_multiple_of(200) {
                turning = random.between(-0.6, 0.6);
            }
            vehicle.drive(Twist2::new(0.4, turning));
            filter.predict(&vehicle.odometry);
        }
        let (truth, pose) = (vehicle.truth, filter.pose());
        let error = nalgebra::Vector3::new(
            pose.x_m - truth.x_m,
            pose.y_m - truth.y_m,
            wrap_angle(pose.theta_rad - truth.theta_rad),
        );
        let inverse = filter.covariance().try_inverse().expect("a covariance");
        let nees = (error.transpose() * inverse * error).x;
        sum += nees;
        beyond += f64::from(u8::from(nees > 11.3));
    }
    let runs = runs as f64;
    assert!((0.1..3.0).contains(&(sum / runs)), "{}", sum / runs);
    assert!(beyond / runs < 0.01, "{beyond}");
}

/// Nothing in view for long: the covariance grows until the pose says so, while it is still right.
#[test]
fn where_nothing_is_in_view_it_grows_uncertain() {
    let place = maps::corridor();
    let start = place.start();
    // The hall is far away; the map says nothing is to be seen here, so that blindness is expected.
    let mut drive = Drive::new(7, &place, Floor::default(), Pose2::IDENTITY);
    drive
        .filter
        .relocate(Pose2::new(100.0, 100.0, 0.0), 0.02, 0.02);
    let mut before_m = drive.filter.position_std_m();
    let mut scans = 0;
    while !drive.filter.is_uncertain() {
        if let Some(sample) = drive.step(Twist2::new(0.4, 0.0)) {
            scans += 1;
            assert!(sample.position_std_m > before_m && scans < 5000);
            before_m = sample.position_std_m;
            let driven_m = start.position().distance_m(drive.vehicle.truth.position());
            let estimated_m = drive
                .filter
                .pose()
                .position()
                .distance_m(Pose2::new(100.0, 100.0, 0.0).position());
            assert!((driven_m - estimated_m).abs() < 3.0 * sample.position_std_m);
        }
    }
    assert!(scans > 50, "{scans}");
}
