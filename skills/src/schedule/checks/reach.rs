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
    /// What it keeps before the border of an area that is not its own, while it knows its place as well as at its start.
    pub ahead_of_border_m: f64,
    /// The same from the border of an area behind it, until that counts as left.
    pub behind_border_m: f64,
}
