//! Among moving discs: none is run into; a disc may run into a robot that stands.

use crate::clutter::robot::Robot;
use crate::clutter::world::{Disc, World};
use crate::random::Random;
use description::geometry::{Point2, Pose2};

const START: Pose2 = Pose2::new(1.0, -0.5, 0.0);
const GOAL_M: f64 = 11.0;
/// Slower than this the robot stands.
const STANDING_M_S: f64 = 0.02;

#[derive(Debug, Default)]
struct Drive {
    arrived: bool,
    duration_s: f64,
    clearance_m: f64,
    /// Discs that came to touch the robot while it stood or from behind, and while it drove.
    touched_standing: usize,
    run_into: Vec<(f64, f64, Disc, Pose2)>,
    moving_stops: u64,
    blocked_stops: u64,
}

fn drive(seed: u64, discs: Vec<Disc>, limit_s: f64) -> Drive {
    let mut world = World::new(Vec::new());
    world.discs = discs;
    let mut robot = Robot::new(seed, world, START);
    let mut drive = Drive {
        clearance_m: f64::INFINITY,
        ..Drive::default()
    };
    let mut touching = false;
    for step in 0..(limit_s * 1e3) as u64 {
        let before_m = robot.plant.driven_m;
        robot.step();
        drive.duration_s = step as f64 * 1e-3;
        drive.clearance_m = drive.clearance_m.min(robot.still_clearance_m());
        let touched = robot.touched();
        if let Some(disc) = touched.filter(|_| !touching) {
            let speed_m_s = (robot.plant.driven_m - before_m) * 1e3;
            if speed_m_s > STANDING_M_S && !comes_from_behind(&robot, &disc) {
                let pose = robot.plant.pose;
                drive
                    .run_into
                    .push((drive.duration_s, speed_m_s, disc, pose));
            } else {
                drive.touched_standing += 1;
            }
        }
        touching = touched.is_some();
        if robot.plant.pose.x_m >= GOAL_M {
            drive.arrived = true;
            break;
        }
    }
    drive.moving_stops = robot.tubes.counters().moving_stops;
    drive.blocked_stops = robot.tubes.counters().blocked_stops;
    drive
}

/// Out of the lidar's view: no robot can help that.
fn comes_from_behind(robot: &Robot, disc: &Disc) -> bool {
    robot.plant.pose.inverse_transform(disc.centre).x_m < 0.0
}

fn disc(x_m: f64, y_m: f64, vx: f64, vy: f64) -> Disc {
    Disc {
        centre: Point2::new(x_m, y_m),
        velocity: Point2::new(vx, vy),
        radius_m: 0.25,
    }
}

#[test]
fn one_that_comes_straight_meets_a_robot_that_stands() {
    for speed_m_s in [0.3, 0.6, 1.0] {
        let drive = drive(1, vec![disc(9.0, -0.5, -speed_m_s, 0.0)], 60.0);
        assert!(drive.run_into.is_empty(), "{speed_m_s}: {drive:.3?}");
        assert!(drive.arrived, "{speed_m_s}: {drive:.3?}");
    }
}

#[test]
fn one_that_passes_on_the_other_lane_hardly_delays() {
    let free_s = drive(2, Vec::new(), 60.0).duration_s;
    for speed_m_s in [0.4, 1.0] {
        let drive = drive(2, vec![disc(9.0, 0.6, -speed_m_s, 0.0)], 60.0);
        assert!(drive.run_into.is_empty() && drive.arrived);
        assert!(drive.duration_s < free_s + 2.0, "{free_s}: {drive:.3?}");
    }
}

#[test]
fn an_empty_corridor_has_nothing_that_moves() {
    for seed in 0..4 {
        let drive = drive(seed, Vec::new(), 60.0);
        let stops = drive.moving_stops + drive.blocked_stops;
        assert!(drive.arrived && stops == 0, "seed {seed}: {drive:.3?}");
        assert!(drive.duration_s < 29.0, "seed {seed}: {drive:.3?}");
    }
}

#[test]
fn among_random_discs() {
    const RUNS: u64 = 30;
    let mut arrived = 0;
    for seed in 0..RUNS {
        let random = &mut Random::new(seed + 100);
        let discs: Vec<Disc> = (0..3)
            .map(|index| {
                let speed_m_s = random.between(0.2, 1.0);
                let heading_rad = random.between(-3.1, 3.1);
                Disc {
                    radius_m: random.between(0.15, 0.3),
                    ..disc(
                        4.0 + 3.0 * f64::from(index),
                        random.between(-1.2, 1.2),
                        speed_m_s * heading_rad.cos(),
                        speed_m_s * heading_rad.sin(),
                    )
                }
            })
            .collect();
        let drive = drive(seed, discs, 120.0);
        assert!(drive.clearance_m > 0.0, "seed {seed}: {drive:.2?}");
        assert!(drive.run_into.is_empty(), "seed {seed}: {drive:.2?}");
        arrived += u64::from(drive.arrived);
    }
    assert!(arrived * 20 >= RUNS * 19, "{arrived} of {RUNS} arrived");
}
