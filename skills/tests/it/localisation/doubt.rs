//! Wrong beginnings, leaps and blindness: the pose comes right, or says that it is not to be trusted.

use crate::localisation::floor::Floor;
use crate::localisation::maps;
use crate::localisation::run::{Drive, TARGET_M, TARGET_RAD};
use description::geometry::{Pose2, Twist2};
use skills::localisation::ScanVerdict;

const STAND: Twist2 = Twist2::new(0.0, 0.0);

#[test]
fn a_wrong_beginning_comes_right_or_is_admitted() {
    for place in [maps::corridor(), maps::t_junction(), maps::pieces()] {
        for case in 0..8u64 {
            let sign = |bit: u64| if case >> bit & 1 == 0 { -1.0 } else { 1.0 };
            let off = Pose2::new(0.3 * sign(0), 0.3 * sign(1), 0.2 * sign(2));
            let floor = Floor::of(place.walls());
            let mut drive = Drive::new(case, &place, floor, off);
            for _ in 0..60 {
                let sample = drive.next().expect("a long way");
                assert!(!sample.confidently_wrong(), "{off:?}: {sample:?}");
            }
            // What the walls beside the lane tell has come right.
            let sample = drive.next().expect("a long way");
            assert!(sample.error().y.abs() < TARGET_M, "{off:?}: {sample:?}");
            assert!(sample.off_rad() < TARGET_RAD, "{off:?}: {sample:?}");
        }
    }
}

#[test]
fn along_a_corridor_it_does_not_claim_what_no_wall_tells() {
    let place = maps::corridor();
    let floor = Floor::of(place.walls());
    let mut drive = Drive::new(3, &place, floor, Pose2::new(0.3, 0.0, 0.0));
    for _ in 0..40 {
        let sample = drive.next().expect("a long way");
        assert!((sample.error().x + 0.3).abs() < 0.05);
        assert!(sample.covariance[(0, 0)].sqrt() > 0.095, "{sample:?}");
    }
    // Until the end comes into view.
    let mut last = None;
    for _ in 0..80 {
        last = drive.next();
    }
    let last = last.expect("a long way");
    assert!(
        last.off_m() < TARGET_M && last.position_std_m < 0.02,
        "{last:?}"
    );
}

#[test]
fn who_is_carried_away_notices() {
    // Through the end wall's place, as seen from where it believes to be; across the lane; turned round.
    for (off, seed) in [
        (Pose2::new(-1.5, 0.0, 0.0), 1),
        (Pose2::new(0.0, 0.7, 0.0), 2),
        (Pose2::new(0.0, 0.0, 0.9), 3),
        (Pose2::new(0.0, 0.0, std::f64::consts::PI), 4),
    ] {
        let place = maps::corridor();
        let mut drive = Drive::new(seed, &place, Floor::of(place.walls()), Pose2::IDENTITY);
        while drive.vehicle.truth.x_m < 7.0 {
            drive.next().expect("a long way");
        }
        drive.vehicle.truth = drive.vehicle.truth.compose(off);
        let mut wrong = 0;
        for _ in 0..60 {
            if let Some(sample) = drive.step(STAND) {
                wrong += u32::from(sample.confidently_wrong());
            }
        }
        for _ in 0..600 {
            if let Some(sample) = drive.step(STAND) {
                assert!(!sample.confidently_wrong(), "{off:?}: {sample:?}");
            }
        }
        assert!(wrong <= 20, "{off:?}: {wrong} scans");
    }
}

#[test]
fn odometry_that_leaps_moves_nothing_and_makes_less_certain() {
    let place = maps::corridor();
    let mut drive = Drive::new(5, &place, Floor::of(place.walls()), Pose2::IDENTITY);
    for _ in 0..30 {
        drive.next().expect("a long way");
    }
    let (before, std_m) = (drive.filter.pose(), drive.filter.position_std_m());
    let mut leapt = drive.vehicle.odometry;
    leapt.pose = leapt.pose.compose(Pose2::new(0.5, 0.0, 0.4));
    leapt.stamp_ns += 10_000_000;
    drive.filter.predict(&leapt);
    assert_eq!(drive.filter.pose(), before);
    assert!(drive.filter.position_std_m() > std_m);
    assert_eq!(drive.filter.counters().odometry_leaps, 1);
    // And every time again, until the pose says that it is lost.
    let mut leaps = 1;
    while !drive.filter.is_uncertain() {
        leapt.pose = leapt.pose.compose(Pose2::new(0.5, 0.0, 0.0));
        leapt.stamp_ns += 10_000_000;
        drive.filter.predict(&leapt);
        leaps += 1;
        assert!(leaps < 20);
    }
    assert_eq!(drive.filter.pose(), before);
}

#[test]
fn walls_that_should_be_there_and_are_not_end_trust_and_bring_it_back() {
    let place = maps::corridor();
    let mut drive = Drive::new(6, &place, Floor::of(place.walls()), Pose2::IDENTITY);
    for _ in 0..10 {
        drive.next().expect("a long way");
    }
    assert!(!drive.filter.is_uncertain());
    let walls = std::mem::take(&mut drive.vehicle.floor.walls);
    let mut scans = 0;
    while !drive.filter.is_uncertain() {
        if let Some(sample) = drive.step(STAND) {
            scans += 1;
            // The first scan was half taken before.
            let contradicts = sample.outcome.verdict == ScanVerdict::Contradicted;
            assert!(contradicts || scans == 1, "{:?}", sample.outcome);
        }
        assert!(scans < 10);
    }
    drive.vehicle.floor.walls = walls;
    let mut scans = 0;
    while drive.filter.is_uncertain() {
        scans += u32::from(drive.step(STAND).is_some());
        assert!(scans < 20);
    }
    assert!(scans >= 3, "{scans}");
    let sample = drive.next().expect("a long way");
    assert!(sample.error().y.abs() < TARGET_M && !sample.confidently_wrong());
}
