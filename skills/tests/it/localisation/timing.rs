//! How long one scan takes: `cargo test --test it localisation::timing -- --ignored --nocapture`.

use crate::localisation::floor::Floor;
use crate::localisation::maps;
use crate::localisation::run::Drive;
use description::geometry::{Footprint, Point2, Rect};
use skills::borders::{AreaSet, BorderGains, BorderGuard};
use std::time::Instant;

/// The corridor with more walls around it, each within the sensor's range from somewhere on the way.
fn crowded(more: u32) -> maps::Place {
    let mut walls = vec![
        [0.0, -1.6, 10.0, -1.6],
        [0.0, 1.6, 10.0, 1.6],
        [10.0, -1.6, 10.0, 1.6],
        [0.0, -1.6, 0.0, 1.6],
    ];
    for index in 0..more {
        let (angle_rad, radius_m) = (0.1 * f64::from(index), 1.9 + 0.25 * f64::from(index % 7));
        let at = |angle_rad: f64| (5.0 + radius_m * angle_rad.cos(), radius_m * angle_rad.sin());
        let ((ax, ay), (bx, by)) = (at(angle_rad), at(angle_rad + 0.15));
        walls.push([ax, ay, bx, by]);
    }
    maps::Place {
        map: maps::map(&walls),
        ..maps::corridor()
    }
}

fn told(what: &str, mut times_ns: Vec<u128>) -> u128 {
    times_ns.sort_unstable();
    let at = |share: usize| times_ns[(times_ns.len() - 1) * share / 100] as f64 * 1e-3;
    println!("{what}: median {:.1} us, p99 {:.1} us", at(50), at(99));
    times_ns[times_ns.len() / 2]
}

#[test]
#[ignore = "a measurement"]
fn of_a_scan_and_of_the_borders() {
    for more in [0, 196] {
        let place = crowded(more);
        let mut drive = Drive::honest(1, &place, Floor::of(place.walls()));
        let mut times_ns = Vec::new();
        while drive.next().is_some() {
            let (mut filter, since) = (drive.filter.clone(), drive.vehicle.since());
            let start = Instant::now();
            filter.see_walls(&mut drive.matcher, &drive.vehicle.scan, since);
            times_ns.push(start.elapsed().as_nanos());
        }
        let median_ns = told(&format!("{} walls", more + 4), times_ns);
        // Far above what it takes, and far below the time between two scans.
        assert!(median_ns < 20_000_000, "{median_ns} ns");
    }
    let cell = |index: u32| {
        let at = Point2::new(f64::from(index % 16), f64::from(index / 16));
        Rect::new(at, at + Point2::new(0.5, 0.5))
    };
    let footprint = Footprint {
        front_m: 0.32,
        rear_m: 0.08,
        left_m: 0.15,
        right_m: 0.15,
    };
    let guard = BorderGuard::new((0..256).map(cell), footprint, BorderGains::default());
    let place = maps::corridor();
    let mut drive = Drive::honest(1, &place, Floor::of(place.walls()));
    let mut times_ns = Vec::new();
    while let Some(sample) = drive.next() {
        let pose = sample.truth;
        let unit = description::geometry::Twist2::new(1.0, 0.3);
        let poses = (1..=60).map(|step| pose.advance(unit, 0.02 * f64::from(step)));
        let start = Instant::now();
        let judged = guard.along_poses(&AreaSet::EMPTY, pose, &sample.covariance, poses);
        times_ns.push(start.elapsed().as_nanos());
        assert!(judged.distance_m.is_finite());
    }
    told("60 poses among 256 areas", times_ns);
}
