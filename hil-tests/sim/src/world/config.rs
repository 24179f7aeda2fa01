//! What a world starts with.

use std::time::Duration;

use super::robot::RobotModel;
use super::scene::Obstacle;

/// What a world starts with.
#[derive(Debug, Clone, PartialEq)]
pub struct WorldConfig {
    /// Decides wheel errors and range noise.
    pub seed: u64,
    /// Walls and obstacles that are there from the start.
    pub obstacles: Vec<Obstacle>,
    /// The robots.
    pub robots: Vec<RobotModel>,
    /// Most truth records kept, of all robots together; each robot writes 50 a second.
    pub log_capacity: usize,
    /// Longest time that one call steps through; the world stands still during anything beyond it.
    pub max_catch_up: Duration,
}

impl Default for WorldConfig {
    /// Empty, seed 0, a log for one robot and an hour, at most 1 s of catching up.
    fn default() -> WorldConfig {
        WorldConfig {
            seed: 0,
            obstacles: Vec::new(),
            robots: Vec::new(),
            log_capacity: 180_000,
            max_catch_up: Duration::from_secs(1),
        }
    }
}
