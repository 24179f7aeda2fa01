//! The guarantee: what is declared free is not entered.

use super::stand::{parameters, with_detours};
use super::world::{BIG, Random, Robot, SMALL, Thing, urg};
use crate::scan::ScanGeometry;
use crate::tubes::TubeId;
use crate::tubes::{MotionTubes, StopRules, TubeSet};
use description::geometry::{Footprint, Point2, Pose2, Twist2};
use description::robot::{Horizon, Tubes};
use proptest::prelude::*;

/// What became of tubes, ahead or behind.
#[derive(Clone, Copy, Debug, Default)]
struct Outcome {
    free: usize,
    blocked_rightly: usize,
    blocked_cautiously: usize,
}

/// What became of all tubes.
#[derive(Clone, Copy, Debug, Default)]
struct Outcomes {
    ahead: Outcome,
    behind: Outcome,
}

impl Outcomes {
    fn add(&mut self, other: Self) {
        for (sum, one) in [
            (&mut self.ahead, other.ahead),
            (&mut self.behind, other.behind),
        ] {
            sum.free += one.free;
            sum.blocked_rightly += one.blocked_rightly;
            sum.blocked_cautiously += one.blocked_cautiously;
        }
    }
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
        horizon_s: set.length_between_m(one) / speed_m_s,
        speed_m_s,
    };
    parts(horizon, Twist2::new(set.twist(one).v_m_s, omega_rad_s))
}

fn parts(horizon: Horizon, twist: Twist2) -> impl Iterator<Item = Pose2> + use<> {
    let steps = (horizon.length_m() / 0.004).ceil() as usize;
    (0..=steps).map(move |step| twist.displacement(horizon.horizon_s * step as f64 / steps as f64))
}

/// Brings a robot into a world of one to three things, some of them at the border of a tube, and drives every tube
/// that is declared free.
fn try_worlds(
    random: &mut Random,
    parameters: &Tubes,
    footprint: &Footprint,
    geometry: ScanGeometry,
    worlds: usize,
) -> Outcomes {
    let mut outcomes = Outcomes::default();
    // A sensor that can judge nothing says so, and there is nothing to test.
    let Ok((set, _)) = TubeSet::generate(parameters, footprint, &geometry) else {
        return outcomes;
    };
    let usable: Vec<_> = set.ids().filter(|&id| !set.is_refused(id)).collect();
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
                random.thing(middle, parameters.sample_step_m)
            })
            .collect();
        // It comes straight in from behind, so that what stands beside it was ahead of it; or in a bend, where what
        // came to be beside it may never have been in view.
        let straight = random.unit() < 0.7;
        let curvature_1_m = if straight {
            0.0
        } else {
            random.between(-1.5, 1.5)
        };
        if let Some(one) = try_world(&set, &things, curvature_1_m) {
            outcomes.add(one);
        }
    }
    outcomes
}

fn try_world(set: &TubeSet, things: &[Thing], curvature_1_m: f64) -> Option<Outcomes> {
    let footprint = set.footprint();
    let approach = Twist2::new(0.8, 0.8 * curvature_1_m);
    let begin = approach.displacement(-1.8);
    let touches = |pose: Pose2| things.iter().any(|thing| thing.overlaps(footprint, pose));
    if (0..=180).any(|i| touches(begin.advance(approach, 0.01 * f64::from(i)))) {
        return None;
    }
    let mut robot = Robot::new(begin, *set.geometry());
    let mut tubes = MotionTubes::new(set.clone(), with_detours(), StopRules::default()).unwrap();
    // Nobody has looked beside it: in a bend it comes back to there.
    tubes.assume_nothing();
    for _ in 0..18 {
        robot.drive(approach, 0.1);
        robot.measure(things);
        tubes.observe(&robot.scan, robot.now_ns).unwrap();
    }
    let mut outcomes = Outcomes::default();
    for id in set.ids().filter(|&id| !set.is_refused(id)) {
        let outcome = if set.is_backward(id) {
            &mut outcomes.behind
        } else {
            &mut outcomes.ahead
        };
        let entered = path(set, id).any(|pose| touches(robot.pose.compose(pose)));
        match (tubes.is_free(id), entered) {
            (true, false) => outcome.free += 1,
            (false, true) => outcome.blocked_rightly += 1,
            (false, false) => outcome.blocked_cautiously += 1,
            (true, true) => panic!(
                "tube of curvature {} over {} m, backward {}, is declared free and enters one of {things:#?}; {footprint:?}, {:?}, {:?}, came at {curvature_1_m} 1/m",
                set.curvature_1_m(id),
                set.horizon(id).length_m(),
                set.is_backward(id),
                set.geometry(),
                set.parameters(),
            ),
        }
    }
    for one in set.ids() {
        let next = TubeId(one.0 + 1);
        let neighbours = (next.0 as usize) < set.len()
            && set.horizon(one) == set.horizon(next)
            && set.is_backward(one) == set.is_backward(next);
        if neighbours && tubes.is_free(one) && tubes.is_free(next) {
            let entered =
                path_between(set, one, next).any(|pose| touches(robot.pose.compose(pose)));
            assert!(
                !entered,
                "both neighbours of a path are free, and it enters one of {things:#?}: {one:?}, {footprint:?}"
            );
        }
    }
    Some(outcomes)
}

fn rows(
    [ahead_m, behind_m]: [&[f64]; 2],
    omega_max_rad_s: f64,
    omega_steps: u32,
    sample_step_m: f64,
) -> Tubes {
    let horizon = |&horizon_s: &f64| Horizon {
        horizon_s,
        speed_m_s: 1.0,
    };
    Tubes {
        horizons: ahead_m.iter().map(horizon).collect(),
        backward_horizons: behind_m.iter().map(horizon).collect(),
        omega_max_rad_s,
        omega_steps,
        sample_step_m,
        // Ideal ranges, but for their rounding to millimetres.
        augment_m: sample_step_m / 2.0 + 0.0006,
        ..parameters()
    }
}

/// The test has teeth: all three outcomes occur, and caution is not the rule.
fn assert_teeth(outcome: Outcome, least: usize) {
    let Outcome {
        free,
        blocked_rightly,
        blocked_cautiously,
    } = outcome;
    assert!(free > 2 * least && blocked_rightly > least, "{outcome:?}");
    assert!(blocked_cautiously < 3 * blocked_rightly, "{outcome:?}");
}

#[test]
fn the_small_robot_never_enters_what_is_free() {
    let mut random = Random(1);
    let geometry = ScanGeometry {
        turn_s: 0.0,
        ..urg()
    };
    let parameters = rows([&[0.3, 0.8, 1.4], &[0.1, 0.18]], 4.0, 31, 0.05);
    let outcomes = try_worlds(&mut random, &parameters, &SMALL, geometry, 500);
    assert_teeth(outcomes.ahead, 2_000);
    assert_teeth(outcomes.behind, 200);
}

#[test]
fn the_big_robot_never_enters_what_is_free() {
    let mut random = Random(2);
    let geometry = ScanGeometry {
        mount: Pose2::new(0.6, 0.0, 0.0),
        turn_s: 0.0,
        ..urg()
    };
    let parameters = rows([&[0.2, 0.5, 1.0], &[0.2, 0.35]], 2.3, 31, 0.05);
    let outcomes = try_worlds(&mut random, &parameters, &BIG, geometry, 250);
    assert_teeth(outcomes.ahead, 1_000);
    assert_teeth(outcomes.behind, 200);
}

/// Any footprint, noses longer than tails and tails longer than noses.
fn any_footprint(random: &mut Random) -> Footprint {
    if random.unit() < 0.2 {
        return BIG;
    }
    Footprint {
        front_m: random.between(0.05, 0.8),
        rear_m: random.between(0.02, 0.6),
        left_m: random.between(0.1, 0.35),
        right_m: random.between(0.1, 0.35),
    }
}

/// A sensor anywhere on the robot, that looks ahead, or nearly all around.
fn any_sensor(random: &mut Random, footprint: &Footprint) -> ScanGeometry {
    let between = |random: &mut Random, low_m: f64, high_m: f64| {
        0.98 * (low_m + (high_m - low_m) * random.unit())
    };
    let all_around = random.unit() < 0.3;
    let (turn_rad, view_deg) = if all_around {
        (random.between(-3.1, 3.1), random.between(300.0, 360.0))
    } else {
        (random.between(-0.4, 0.4), random.between(180.0, 300.0))
    };
    let mount = Pose2::new(
        between(random, -footprint.rear_m, footprint.front_m),
        between(random, -footprint.right_m, footprint.left_m),
        turn_rad,
    );
    let step_rad = random.between(0.25, 0.5f64).to_radians();
    let beams = (view_deg.to_radians() / step_rad) as usize;
    ScanGeometry {
        mount,
        angle_first_rad: -step_rad * (beams - 1) as f64 / 2.0,
        angle_step_rad: step_rad,
        beams,
        range_min_m: 0.02,
        range_max_m: 4.0,
        turn_s: 0.0,
    }
}

/// Random robots in random worlds.
fn any_robot(seed: u64) -> Outcomes {
    let random = &mut Random(seed);
    let footprint = any_footprint(random);
    let geometry = any_sensor(random, &footprint);
    let ahead_m = [random.between(0.15, 0.5), random.between(0.6, 1.2)];
    let behind_m = [random.between(0.05, 0.2), random.between(0.25, 0.6)];
    let sample_step_m = random.between(0.05, 0.12);
    let parameters = Tubes {
        augment_m: sample_step_m / 2.0 + random.between(0.0006, 0.03),
        ..rows([&ahead_m, &behind_m], 2.5, 21, sample_step_m)
    };
    try_worlds(random, &parameters, &footprint, geometry, 6)
}

#[test]
fn random_robots_drive_both_ways() {
    let mut outcomes = Outcomes::default();
    for seed in 0..40 {
        outcomes.add(any_robot(seed));
    }
    assert_teeth(outcomes.ahead, 100);
    assert_teeth(outcomes.behind, 50);
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 24, ..ProptestConfig::default() })]

    #[test]
    fn no_robot_enters_what_is_free(seed in any::<u64>()) {
        any_robot(seed);
    }
}
