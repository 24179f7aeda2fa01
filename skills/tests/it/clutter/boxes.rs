//! Around boxes that leave a gap, and back to the lane.

use crate::clutter::robot::Robot;
use crate::clutter::world::{World, rect};
use crate::random::Random;
use description::geometry::{Pose2, Rect};

const START: Pose2 = Pose2::new(1.0, -0.5, 0.0);
const GOAL_M: f64 = 11.0;

#[derive(Debug, Default)]
struct Drive {
    arrived: bool,
    duration_s: f64,
    clearance_m: f64,
    lateral_m: f64,
    stops: u64,
    detours: u64,
    side_changes: u64,
    /// Changes of the commanded curvature by more than one 1/m from one command to the next.
    jerks: usize,
    at: Pose2,
}

fn drive(seed: u64, boxes: Vec<Rect>, limit_s: f64) -> Drive {
    let mut robot = Robot::new(seed, World::new(boxes), START);
    let mut drive = Drive {
        clearance_m: f64::INFINITY,
        ..Drive::default()
    };
    let mut before_1_m = 0.0;
    for step in 0..(limit_s * 1e3) as u64 {
        let asked = robot.step();
        drive.clearance_m = drive.clearance_m.min(robot.still_clearance_m());
        if asked {
            let curvature_1_m = robot.adapted.command.curvature_1_m;
            drive.jerks += usize::from((curvature_1_m - before_1_m).abs() > 1.0);
            before_1_m = curvature_1_m;
        }
        drive.duration_s = step as f64 * 1e-3;
        if robot.plant.pose.x_m >= GOAL_M {
            drive.arrived = true;
            break;
        }
    }
    let counters = robot.tubes.counters();
    drive.stops = counters.blocked_stops;
    drive.detours = counters.detours;
    drive.side_changes = counters.detour_side_changes;
    drive.lateral_m = robot.plant.pose.y_m + 0.5;
    drive.at = robot.plant.pose;
    drive
}

#[test]
fn a_box_on_the_lane_is_passed_and_the_lane_taken_again() {
    for (name, one) in [
        ("middle", rect([5.0, -0.7], [5.4, -0.3])),
        ("left half", rect([5.0, -0.5], [5.4, -0.1])),
        ("right half", rect([5.0, -0.9], [5.4, -0.5])),
        ("to the right wall", rect([5.0, -1.6], [5.4, -0.2])),
        ("to the left wall", rect([5.0, -0.8], [5.4, 1.6])),
        ("long", rect([5.0, -0.7], [6.6, -0.3])),
        ("wide", rect([5.0, -0.9], [5.2, 0.3])),
    ] {
        let drive = drive(1, vec![one], 90.0);
        assert!(
            drive.arrived && drive.clearance_m > 0.0,
            "{name}: {drive:.3?}"
        );
        assert!(drive.lateral_m.abs() < 0.06, "{name}: {drive:.3?}");
        // No flutter: a few turns of the wheel on the way around, and no second thoughts about the side.
        assert!(drive.jerks <= 10, "{name}: {drive:.3?}");
        assert!(
            drive.side_changes == 0 && drive.stops == 0,
            "{name}: {drive:.3?}"
        );
    }
}

#[test]
fn through_random_boxes() {
    let mut arrived = 0;
    const RUNS: u64 = 40;
    for seed in 0..RUNS {
        let random = &mut Random::new(seed);
        let mut boxes: Vec<Rect> = Vec::new();
        for index in 0..3 {
            let x_m = 3.0 + 2.6 * f64::from(index) + random.between(-0.3, 0.3);
            let y_m = random.between(-1.4, 1.4);
            let (half_x, half_y) = (random.between(0.08, 0.3), random.between(0.08, 0.4));
            boxes.push(rect(
                [x_m - half_x, (y_m - half_y).max(-1.6)],
                [x_m + half_x, (y_m + half_y).min(1.6)],
            ));
        }
        let drive = drive(seed, boxes.clone(), 150.0);
        assert!(
            drive.clearance_m > 0.0,
            "seed {seed}: {drive:.3?} {boxes:.2?}"
        );
        arrived += u64::from(drive.arrived);
    }
    assert!(arrived * 20 >= RUNS * 19, "{arrived} of {RUNS} arrived");
}
