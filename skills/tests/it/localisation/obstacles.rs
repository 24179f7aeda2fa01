//! What stands or walks before the walls does not pull the pose.

use crate::localisation::floor::{Disc, Floor};
use crate::localisation::maps::{self, Place};
use crate::localisation::run::{Drive, TARGET_M, TARGET_RAD, seeds};
use crate::random::Random;
use description::geometry::{Point2, Pose2};

/// A robot parked parallel to each short wall and two before each long one, 2 to 25 cm away; three people walk about.
fn cluttered(place: &Place, seed: u64) -> Floor {
    let mut random = Random::new(seed + 1000);
    let mut floor = Floor::of(place.walls());
    for wall in place.walls() {
        let robots = if wall.length_m() < 4.0 { 1 } else { 2 };
        for _ in 0..robots {
            let gap_m = random.between(0.02, 0.25);
            let (length_m, width_m) = if random.uniform() < 0.5 {
                (0.4, 0.3)
            } else {
                (0.9, 0.2)
            };
            let unit = wall.unit();
            let along = unit * (random.between(0.2, 0.8) * wall.length_m());
            for side in [1.0, -1.0] {
                let off_m = side * (gap_m + width_m / 2.0);
                let at = wall.a + along + Point2::new(-unit.y_m, unit.x_m) * off_m;
                let pose = Pose2::new(at.x_m, at.y_m, wall.direction_rad());
                floor.put_box(pose, length_m, width_m);
            }
        }
    }
    for _ in 0..3 {
        floor.discs.push(Disc {
            at: Point2::new(random.between(0.0, 8.0), random.between(-1.0, 1.0)),
            radius_m: 0.2,
            moves_m_s: Point2::new(random.between(-0.1, 0.1), random.between(-0.02, 0.02)),
        });
    }
    floor
}

fn drive(place: &Place, seed: u64) {
    let mut drive = Drive::honest(seed, place, cluttered(place, seed));
    let (mut scans, mut wrong) = (0, 0);
    while let Some(sample) = drive.next() {
        scans += 1;
        wrong += u32::from(sample.confidently_wrong());
        assert!(!sample.uncertain, "seed {seed}: {sample:?}");
        if sample.position_std_m < 0.02 {
            assert!(sample.off_m() < TARGET_M, "seed {seed}: {sample:?}");
        }
        if scans > 5 && sample.heading_std_rad < 0.01 {
            assert!(sample.off_rad() < TARGET_RAD, "seed {seed}: {sample:?}");
        }
    }
    assert_eq!(wrong, 0, "seed {seed}: of {scans}");
}

#[test]
fn parked_robots_and_people_in_the_corridor() {
    for seed in seeds(2) {
        drive(&maps::corridor(), seed);
    }
}

#[test]
fn parked_robots_and_people_in_the_docking_hall() {
    for seed in seeds(2) {
        drive(&maps::docking(), seed);
    }
}

#[test]
fn parked_robots_and_people_in_the_t_junction() {
    for seed in seeds(2) {
        drive(&maps::t_junction(), seed);
    }
}

#[test]
fn parked_robots_and_people_between_pieces_of_wall() {
    for seed in seeds(2) {
        drive(&maps::pieces(), seed);
    }
}

/// A robot right beside, that hides most of one wall for as long as it takes.
#[test]
fn a_long_robot_alongside_is_not_the_wall() {
    let place = maps::corridor();
    for gap_m in [0.05, 0.1, 0.2, 0.4] {
        let mut floor = Floor::of(place.walls());
        let south_m = -1.6 + gap_m + 0.1;
        floor.put_box(Pose2::new(3.2, south_m, 0.0), 2.0, 0.2);
        floor.put_box(Pose2::new(5.5, south_m, 0.0), 2.0, 0.2);
        let mut drive = Drive::new(9, &place, floor, Pose2::IDENTITY);
        for _ in 0..80 {
            let sample = drive.next().expect("a long way");
            assert!(sample.error().y.abs() < TARGET_M, "{gap_m}: {sample:?}");
            assert!(sample.off_rad() < TARGET_RAD && !sample.uncertain);
        }
    }
}
