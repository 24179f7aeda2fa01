//! What a map is built from, as plain data.

use description::geometry::{Rect, Segment};

/// A straight wall.
#[derive(Clone, Debug, PartialEq)]
pub struct WallData {
    /// Unique among walls.
    pub id: String,
    /// Where it is.
    pub line: Segment,
}

/// A directed lane.
#[derive(Clone, Debug, PartialEq)]
pub struct LaneData {
    /// Unique among lanes.
    pub id: String,
    /// Its centre line, in the direction of driving.
    pub line: Segment,
    /// The wall that closes it ahead; without a name the nearest wall that crosses it.
    pub end_wall: Option<String>,
}

/// An area and what it allows.
#[derive(Clone, Debug, PartialEq)]
pub struct AreaData {
    /// Unique among areas.
    pub id: String,
    /// Where it is.
    pub region: Rect,
    /// The lane that runs through it.
    pub lane: Option<String>,
    /// Fastest speed in it.
    pub speed_limit_m_s: f64,
    /// Farthest from the lane's centre.
    pub deviation_limit_m: f64,
}

/// All that a map is built from.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MapData {
    /// Walls.
    pub walls: Vec<WallData>,
    /// Lanes.
    pub lanes: Vec<LaneData>,
    /// Areas.
    pub areas: Vec<AreaData>,
}
