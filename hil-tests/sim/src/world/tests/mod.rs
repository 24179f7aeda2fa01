//! The world against closed forms and against itself.

mod collision;
mod kinematics;
mod ranges;
mod repeatability;
mod walkers;

use std::time::Duration;

use super::*;
use crate::plant::DriveCommand;

const MS: u64 = 1_000_000;
const START_NS: u64 = 1_000_000_000;

/// A robot with perfect wheels.
fn exact_robot(id: &str, start: Pose) -> RobotModel {
    RobotModel {
        wheel_scale_error: 0.0,
        ..RobotModel::new(id, start)
    }
}

fn world(obstacles: Vec<Obstacle>, robots: Vec<RobotModel>) -> World {
    let mut world = World::new(WorldConfig {
        seed: 7,
        obstacles,
        robots,
        max_catch_up: Duration::from_secs(100),
        ..WorldConfig::default()
    })
    .unwrap();
    world.advance_to(START_NS);
    world
}

fn wheels(left_rad_s: f64, right_rad_s: f64) -> DriveCommand {
    DriveCommand {
        left_enabled: true,
        right_enabled: true,
        left_rad_s,
        right_rad_s,
        left_current_limit_a: 1e6,
        right_current_limit_a: 1e6,
    }
}

/// Holds a command for `duration_ms`, as a bus at 1 kHz would.
fn drive(world: &mut World, robot: usize, command: &DriveCommand, duration_ms: u64) {
    let from_ns = world.now_ns();
    for ms in 0..duration_ms {
        world.exchange(robot, from_ns + ms * MS, command);
    }
    world.advance_to(from_ns + duration_ms * MS);
}

fn room(half_m: f64) -> Vec<Obstacle> {
    let corners = [
        [-half_m, -half_m],
        [half_m, -half_m],
        [half_m, half_m],
        [-half_m, half_m],
    ];
    (0..4)
        .map(|i| Obstacle::wall(corners[i], corners[(i + 1) % 4]))
        .collect()
}
