//! How exact the pose is where features are in view.

use crate::localisation::floor::Floor;
use crate::localisation::maps::{self, Place};
use crate::localisation::run::{Drive, TARGET_M, TARGET_RAD, seeds};

/// Drives the whole way; returns the share of scans after which the whole position was known well.
fn drive(place: &Place, seed: u64) -> f64 {
    let mut drive = Drive::honest(seed, place, Floor::of(place.walls()));
    let (mut scans, mut known) = (0, 0);
    while let Some(sample) = drive.next() {
        scans += 1;
        assert!(
            !sample.uncertain && !sample.confidently_wrong(),
            "{sample:?}"
        );
        // What a wall in view tells is known to the target; along an empty corridor the covariance says what is not.
        if sample.position_std_m < 0.02 {
            known += 1;
            assert!(sample.off_m() < TARGET_M, "seed {seed}: {sample:?}");
        }
        if scans > 3 {
            assert!(sample.off_rad() < TARGET_RAD, "seed {seed}: {sample:?}");
            assert!(sample.outcome.corrected > 0 && sample.outcome.beams.walls_through == 0);
        }
    }
    f64::from(known) / f64::from(scans)
}

#[test]
fn in_the_corridor() {
    for seed in seeds(2) {
        let known = drive(&maps::corridor(), seed);
        assert!(known > 0.35, "{known}");
    }
}

#[test]
fn in_the_docking_hall() {
    for seed in seeds(2) {
        let known = drive(&maps::docking(), seed);
        assert!(known > 0.25, "{known}");
    }
}

#[test]
fn in_the_t_junction() {
    for seed in seeds(2) {
        let known = drive(&maps::t_junction(), seed);
        assert!(known > 0.55, "{known}");
    }
}

#[test]
fn between_pieces_of_wall_openings_and_pillars() {
    for seed in seeds(2) {
        let known = drive(&maps::pieces(), seed);
        assert!(known > 0.8, "{known}");
    }
}
