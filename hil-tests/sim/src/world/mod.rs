//! The world: walls, obstacles, people who walk about, robots that see and can hit each other, and the truth about them.
//!
//! A [`World`] is a pure value. It advances in steps of 1 ms on a fixed grid, so looking at it never changes what
//! happens, and the same seed with the same commands at the same times gives the same bits. [`SharedWorld`] lets the
//! threads of simulated devices share one. Time is the monotonic clock's, in nanoseconds; a test may use any.
//!
//! ```
//! use sim::plant::{DriveCommand, Plant};
//! use sim::world::{Obstacle, Pose, RobotModel, SharedWorld, WorldConfig};
//!
//! let world = SharedWorld::new(WorldConfig {
//!     seed: 1,
//!     obstacles: vec![Obstacle::wall([3.0, -1.0], [3.0, 1.0])],
//!     robots: vec![RobotModel::new("amr-1", Pose::default())],
//!     ..WorldConfig::default()
//! })?;
//! let mut robot = world.robot("amr-1")?;
//! let sensors = robot.exchange(1_000_000_000, &DriveCommand::OFF);
//! assert_eq!(sensors.left_rad_s, 0.0);
//! assert!((robot.truth().clearance_m - 2.68).abs() < 1e-9);
//! # Ok::<(), sim::world::WorldError>(())
//! ```

mod collision;
mod config;
mod error;
mod geometry;
mod random;
mod range_finder;
mod robot;
mod robot_state;
mod room;
mod scene;
mod shared;
mod simulation;
#[cfg(test)]
mod tests;
mod truth;
mod walker;
mod wheel;

pub use crate::range_source::{RANGE_STEPS, STEPS_PER_TURN};
pub use collision::{Cause, Collision, STANDING_M_S};
pub use config::WorldConfig;
pub use error::WorldError;
pub use geometry::{Footprint, Point, Pose, Rectangle, Segment, Twist, ray_hit_disc_m};
pub use random::Random;
pub use range_finder::{RangeFinder, RangeModel};
pub use robot::RobotModel;
pub use scene::{MAX_OBSTACLES, Obstacle, ObstacleId, Shape};
pub use shared::{RobotHandle, SharedWorld, WorldRangeSource};
pub use simulation::{COMMAND_TIMEOUT, STEP, World};
pub use truth::{Truth, TruthLog, TruthRecord};
pub use walker::{BEHIND_RAD, Body, Route, Walker};
pub use wheel::Mechanics;
