//! What a judge finds out about one run.

use std::collections::BTreeSet;

use serde::{Deserialize, Deserializer, Serialize};

/// What came out.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Figures {
    /// From the start to the last look.
    pub duration_s: f64,
    /// Way driven.
    pub distance_m: f64,
    /// Collisions in which the robot moved and what it touched stood.
    pub drove_into: u64,
    /// Collisions in which both moved.
    pub met: u64,
    /// Collisions in which the robot stood and was run into.
    pub run_into: u64,
    /// Smallest distance of the footprint to anything.
    #[serde(deserialize_with = "or_infinite")]
    pub min_clearance_m: f64,
    /// Largest error of the pose across a wall in view.
    pub max_pose_error_m: f64,
    /// Largest error of the heading while a wall is in view.
    pub max_heading_error_rad: f64,
    /// Largest error of the position, in view or not.
    pub max_position_error_m: f64,
    /// Errors of stops at walls.
    pub dock_errors_m: Vec<f64>,
    /// Errors of stops at poses.
    pub pose_stop_errors_m: Vec<f64>,
    /// Errors of stops before areas.
    pub border_stop_errors_m: Vec<f64>,
    /// Least distance to an area without leave while the robot stood before it.
    #[serde(deserialize_with = "or_infinite")]
    pub min_border_m: f64,
    /// Largest excess over the speed limit of the area under `base_link`.
    pub max_over_speed_m_s: f64,
    /// How long the motion tubes held it.
    pub held_s: f64,
    /// Longest time that it stood.
    pub longest_stand_s: f64,
    /// Skills that ran.
    pub skills: BTreeSet<String>,
    /// States that its machine was in, in order, each time.
    pub states: Vec<String>,
    /// Areas that `base_link` was in.
    pub areas: BTreeSet<String>,
}

/// A least distance: JSON has `null` where nothing was near.
pub(crate) fn or_infinite<'de, D: Deserializer<'de>>(from: D) -> Result<f64, D::Error> {
    Ok(Option::deserialize(from)?.unwrap_or(f64::INFINITY))
}
