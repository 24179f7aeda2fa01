//! How much room a robot has, as somebody sees who stands beside it.

use super::geometry::Pose;
use super::simulation::World;

/// In steps of this way,
const STEP_M: f64 = 0.05;
/// and so far from everything, people say that floor is free.
const APART_M: f64 = 0.05;

impl World {
    /// How far a robot could move straight back from where it stands without coming close to anything, at most `most_m`.
    #[must_use]
    pub fn free_behind_m(&self, robot: usize, most_m: f64) -> f64 {
        let Some(truth) = self.truth(robot) else {
            return 0.0;
        };
        let mut moved = self.snapshot();
        let (sin, cos) = truth.pose.theta_rad.sin_cos();
        let ways_m = (1..).map(|step| f64::from(step) * STEP_M);
        ways_m
            .take_while(|&way_m| {
                let pose = Pose {
                    x_m: truth.pose.x_m - way_m * cos,
                    y_m: truth.pose.y_m - way_m * sin,
                    ..truth.pose
                };
                moved.robots[robot].set_down(pose);
                way_m <= most_m && moved.clearance_below(robot, APART_M) >= APART_M
            })
            .last()
            .unwrap_or(0.0)
    }

    /// How far a robot would be from everything else if it stood somewhere, at most `most_m`.
    #[must_use]
    pub fn clearance_at_m(&self, robot: usize, pose: Pose, most_m: f64) -> f64 {
        let mut moved = self.snapshot();
        let Some(model) = moved.robots.get_mut(robot) else {
            return 0.0;
        };
        model.set_down(pose);
        moved.clearance_below(robot, most_m)
    }
}

#[cfg(test)]
mod tests {
    use crate::world::{Obstacle, Pose, RobotModel, World, WorldConfig};

    #[test]
    fn it_ends_before_what_stands_there() {
        let world = |obstacles| {
            World::new(WorldConfig {
                seed: 1,
                obstacles,
                robots: vec![RobotModel::new("amr-1", Pose::new(0.0, 0.0, 0.0))],
                ..WorldConfig::default()
            })
        };
        let behind = vec![Obstacle::wall([-1.0, -1.0], [-1.0, 1.0])];
        let blocked = world(behind).expect("a world");
        let rear_m = { blocked.models() }
            .map(|model| model.footprint.rear_m)
            .sum::<f64>();
        let free_m = blocked.free_behind_m(0, 2.0);
        let room_m = 1.0 - rear_m;
        assert!(free_m < room_m && free_m > room_m - 0.11, "{free_m}");
        let open = world(Vec::new()).expect("a world");
        assert!((open.free_behind_m(0, 2.0) - 2.0).abs() < 1e-9);
        assert_eq!(open.free_behind_m(7, 2.0), 0.0);
    }
}
