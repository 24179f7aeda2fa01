//! The guarantee: what is declared free is not entered.

use super::world::{Random, Robot, SMALL, Thing, urg};
use crate::geometry::{Footprint, Point2, Pose2, Twist2};
use crate::scan::ScanGeometry;
use crate::tubes::set::TubeId;
use crate::tubes::{AdaptPolicy, Horizon, MotionTubes, TubeParameters, TubeSet};
use proptest::prelude::*;

struct Outcome {
    free: usize,
    blocked_rightly: usize,
    blocked_cautiously: usize,
}

/// The parts of a tube's path, 4 mm apart.
fn path(set: &TubeSet, id: TubeId) -> impl Iterator<Item = Pose2> + use<> {
    parts(set.horizon(id), set.twist(id))
}

/// The parts of the path halfway between a tube and the next.
fn path_between(set: &TubeSet, one: TubeId, next: TubeId) -> impl Iterator<Item = Pose2> + use<> {
    let omega_rad_s = (set.twist(one).omega_rad_s + set.twist(next).omega_rad_s) / 2.0;
    let speed_m_s = set.horizon(one).speed_m_s;
    let horizon = Horizon {
        duration_s: set.length_between_m(one) / speed_m_s,
        speed_m_s,
    };
    parts(horizon, Twist2::new(speed_m_s, omega_rad_s))
}

fn parts(horizon: Horizon, twist: Twist2) -> impl Iterator<Item = Pose2> + use<> {
    let steps = (horizon.length_m() / 0.004).ceil() as usize;
    (0..=steps).map(move |step| twist.displacement(horizon.duration_s * step as f64 / steps as f64))
}

/// Brings a robot into a world of one to three things, some of them at the border of a tube, and drives every tube
/// that is declared free.
fn try_worlds(
    random: &mut Random,
    parameters: &TubeParameters,
    footprint: &Footprint,
    geometry: ScanGeometry,
    worlds: usize,
) -> Outcome {
    let (set, _) = TubeSet::generate(parameters, footprint, &geometry).unwrap();
    let usable: Vec<_> = set.ids().filter(|&id| !set.is_refused(id)).collect();
    let mut outcome = Outcome {
        free: 0,
        blocked_rightly: 0,
        blocked_cautiously: 0,
    };
    for _ in 0..worlds {
        let things: Vec<Thing> = (0..1 + random.below(3))
            .map(|_| {
                let middle = if random.unit() < 0.7 {
                    // About where some tube's robot will have a side.
                    let id = usable[random.below(usable.len())];
                    let poses: Vec<Pose2> = path(&set, id).collect();
                    let pose = poses[random.below(poses.len())];
                    let corners = footprint.corners();
                    let corner = random.below(4);
                    let along = random.unit();
                    let side = corners[corner] * along + corners[(corner + 1) % 4] * (1.0 - along);
                    let off = 0.1;
                    pose.transform(side)
                        + Point2::new(random.between(-off, off), random.between(-off, off))
                } else {
                    Point2::new(random.between(-1.0, 2.5), random.between(-2.0, 2.0))
                };
                random.thing(middle, parameters.d_sample_m)
            })
            .collect();
        if let Some(one) = try_world(&set, &things) {
            outcome.free += one.free;
            outcome.blocked_rightly += one.blocked_rightly;
            outcome.blocked_cautiously += one.blocked_cautiously;
        }
    }
    outcome
}

fn try_world(set: &TubeSet, things: &[Thing]) -> Option<Outcome> {
    let footprint = set.footprint();
    // It comes straight in from behind, so that what stands beside it was ahead of it.
    let approach = Twist2::new(0.8, 0.0);
    let begin = Pose2::new(-0.8 * 1.8, 0.0, 0.0);
    let touches = |pose: Pose2| things.iter().any(|thing| thing.overlaps(footprint, pose));
    if (0..=180).any(|i| touches(begin.advance(approach, 0.01 * f64::from(i)))) {
        return None;
    }
    let mut robot = Robot::new(begin, *set.geometry());
    let mut tubes = MotionTubes::new(set.clone(), AdaptPolicy::default()).unwrap();
    for _ in 0..18 {
        robot.drive(approach, 0.1);
        robot.measure(things);
        tubes.observe(&robot.scan, robot.now_ns).unwrap();
    }
    let mut outcome = Outcome {
        free: 0,
        blocked_rightly: 0,
        blocked_cautiously: 0,
    };
    for id in set.ids().filter(|&id| !set.is_refused(id)) {
        let entered = path(set, id).any(|pose| touches(robot.pose.compose(pose)));
        match (tubes.is_free(id), entered) {
            (true, false) => outcome.free += 1,
            (false, true) => outcome.blocked_rightly += 1,
            (false, false) => outcome.blocked_cautiously += 1,
            (true, true) => panic!(
                "tube of curvature {} over {} m is declared free and enters one of {things:#?}; {footprint:?}, {:?}, {:?}",
                set.curvature_1_m(id),
                set.horizon(id).length_m(),
                set.geometry(),
                set.parameters(),
            ),
        }
    }
    for one in set.ids() {
        let next = TubeId(one.0 + 1);
        let neighbours = (next.0 as usize) < set.len() && set.horizon(one) == set.horizon(next);
        if neighbours && tubes.is_free(one) && tubes.is_free(next) {
            let entered =
                path_between(set, one, next).any(|pose| touches(robot.pose.compose(pose)));
            assert!(
                !entered,
                "both neighbours of a path are free, and it enters one of {things:#?}: {one:?}, {footprint:?}"
            );
        }
    }
    Some(outcome)
}

fn rows(
    lengths_m: &[f64],
    omega_max_rad_s: f64,
    omega_steps: usize,
    d_sample_m: f64,
) -> TubeParameters {
    TubeParameters {
        horizons: lengths_m
            .iter()
            .map(|&duration_s| Horizon {
                duration_s,
                speed_m_s: 1.0,
            })
            .collect(),
        omega_max_rad_s,
        omega_steps,
        d_sample_m,
        // Ideal ranges, but for their rounding to millimetres.
        d_aug_m: d_sample_m / 2.0 + 0.0006,
        backward: Vec::new(),
        ..TubeParameters::default()
    }
}

#[test]
fn the_small_robot_never_enters_what_is_free() {
    let mut random = Random(1);
    let geometry = ScanGeometry {
        turn_s: 0.0,
        ..urg()
    };
    let parameters = rows(&[0.3, 0.8, 1.4], 4.0, 31, 0.05);
    let outcome = try_worlds(&mut random, &parameters, &SMALL, geometry, 1500);
    // The test has teeth: all three outcomes occur, and caution is not the rule.
    assert!(outcome.free > 20_000, "{} free", outcome.free);
    assert!(
        outcome.blocked_rightly > 10_000,
        "{} blocked",
        outcome.blocked_rightly
    );
    assert!(
        outcome.blocked_cautiously < outcome.blocked_rightly,
        "{} cautious, {} right",
        outcome.blocked_cautiously,
        outcome.blocked_rightly
    );
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 64, ..ProptestConfig::default() })]

    #[test]
    fn no_robot_enters_what_is_free(seed in any::<u64>()) {
        let random = &mut Random(seed);
        let front_m = random.between(0.2, 0.8);
        let footprint = Footprint {
            front_m,
            rear_m: random.between(0.02, 0.3).min(front_m),
            left_m: random.between(0.1, 0.35),
            right_m: random.between(0.1, 0.35),
        };
        let mount = Pose2::new(
            random.between(0.3, 0.98) * footprint.front_m,
            random.between(-0.5, 0.5) * footprint.right_m.min(footprint.left_m),
            random.between(-0.3, 0.3),
        );
        let step_rad = random.between(0.25, 0.5f64).to_radians();
        let view_rad = random.between(180.0, 300.0f64).to_radians();
        let beams = (view_rad / step_rad) as usize;
        let geometry = ScanGeometry {
            mount,
            angle_first_rad: -step_rad * (beams - 1) as f64 / 2.0,
            angle_step_rad: step_rad,
            beams,
            range_min_m: 0.02,
            range_max_m: 4.0,
            turn_s: 0.0,
        };
        let lengths_m = [random.between(0.15, 0.5), random.between(0.6, 1.2)];
        let d_sample_m = random.between(0.05, 0.12);
        let parameters = rows(&lengths_m, 2.5, 21, d_sample_m);
        try_worlds(random, &parameters, &footprint, geometry, 6);
    }
}
