//! What a robot can reach.

use description::geometry::Footprint;

/// What the robot's body, lidar and tubes allow.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RobotReach {
    /// Outline.
    pub footprint: Footprint,
    /// How far ahead of `base_link` the lidar sees.
    pub sees_m: f64,
    /// Tightest curve that a motion tube follows.
    pub tube_curvature_1_m: f64,
}
