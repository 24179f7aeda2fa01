//! The semantic map: walls, directed lanes and areas, built from plain data and checked.
//!
//! A lane knows the walls that perception should expect beside it and at its end. Everything is in the `map` frame.
//!
//! ```
//! use skills::geometry::{Point2, Rect, Segment};
//! use skills::map::{LaneData, MapData, SemanticMap, WallData};
//! let wall = |id: &str, x0, y0, x1, y1| WallData {
//!     id: id.into(),
//!     line: Segment::new(Point2::new(x0, y0), Point2::new(x1, y1)),
//! };
//! let map = SemanticMap::new(&MapData {
//!     walls: vec![wall("south", 0.0, -1.6, 10.0, -1.6), wall("east", 10.0, -1.6, 10.0, 1.6)],
//!     lanes: vec![LaneData {
//!         id: "out".into(),
//!         line: Segment::new(Point2::new(1.0, -0.5), Point2::new(9.0, -0.5)),
//!         end_wall: Some("east".into()),
//!     }],
//!     areas: vec![],
//! })?;
//! let lane = &map.lanes()[0];
//! assert!(lane.left.is_none() && lane.right.is_some() && lane.end.is_some());
//! # Ok::<(), skills::map::MapError>(())
//! ```

use crate::geometry::{Point2, Pose2, Rect, Segment, wrap_angle};
use std::f64::consts::FRAC_PI_2;

/// Walls beside a lane are parallel to it within this.
const PARALLEL_RAD: f64 = 0.06;
/// The wall that ends a lane crosses it at this angle or more.
const CROSSING_RAD: f64 = 0.8;
/// Farther from the lane a wall is not part of its corridor.
const BESIDE_M: f64 = 4.0;
/// A wall must run beside the lane for this length.
const OVERLAP_M: f64 = 1.0;
/// A lane's end wall lies at most this far behind its end.
const AHEAD_M: f64 = 5.0;

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

/// A wall as a lane knows it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LaneWall {
    /// Index of the wall in the map.
    pub index: usize,
    /// Directed like the lane when it runs beside it.
    pub line: Segment,
    /// Direction of `line`.
    pub direction_rad: f64,
}

/// A lane with its surroundings.
#[derive(Clone, Debug, PartialEq)]
pub struct LaneGeometry {
    /// Name.
    pub id: String,
    /// Centre line.
    pub line: Segment,
    /// Direction of driving.
    pub direction_rad: f64,
    /// The nearest wall to the left.
    pub left: Option<LaneWall>,
    /// The nearest wall to the right.
    pub right: Option<LaneWall>,
    /// The wall that closes the lane.
    pub end: Option<LaneWall>,
}

impl LaneGeometry {
    /// The pose in `map` at a place along the lane, off its centre, turned against it.
    #[must_use]
    pub fn pose_at(&self, along_m: f64, lateral_m: f64, heading_rad: f64) -> Pose2 {
        let unit = self.line.unit();
        let left = Point2::new(-unit.y_m, unit.x_m);
        let position = self.line.a + unit * along_m + left * lateral_m;
        Pose2::new(
            position.x_m,
            position.y_m,
            wrap_angle(self.direction_rad + heading_rad),
        )
    }
}

/// An area as navigation uses it.
#[derive(Clone, Debug, PartialEq)]
pub struct Area {
    /// Name.
    pub id: String,
    /// Where it is.
    pub region: Rect,
    /// Index of its lane.
    pub lane: Option<usize>,
    /// Fastest speed in it.
    pub speed_limit_m_s: f64,
    /// Farthest from the lane's centre.
    pub deviation_limit_m: f64,
}

/// What is wrong with a map's data.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum MapError {
    /// A name is used twice.
    #[error("two {kind}s are called `{id}`")]
    Duplicate {
        /// Wall, lane or area.
        kind: &'static str,
        /// The name.
        id: String,
    },
    /// A wall or lane has no length, or a number is not finite.
    #[error("{kind} `{id}` must have a finite length above zero")]
    NoLength {
        /// Wall or lane.
        kind: &'static str,
        /// The name.
        id: String,
    },
    /// A name that nothing has.
    #[error("{kind} `{id}` names the {wanted} `{name}`, which does not exist")]
    Unknown {
        /// What names it.
        kind: &'static str,
        /// Its name.
        id: String,
        /// What is named.
        wanted: &'static str,
        /// The name that nothing has.
        name: String,
    },
    /// The end wall lies beside or behind the lane.
    #[error(
        "wall `{wall}` does not close lane `{lane}`: it must cross the lane's line ahead of its start"
    )]
    NotAcross {
        /// The lane.
        lane: String,
        /// The wall.
        wall: String,
    },
    /// A limit of an area is not a positive number.
    #[error("{what} of area `{id}` must be positive, found {found}")]
    Limit {
        /// The area.
        id: String,
        /// Which limit.
        what: &'static str,
        /// Found.
        found: f64,
    },
}

/// The map, checked, with everything resolved.
#[derive(Clone, Debug, PartialEq)]
pub struct SemanticMap {
    lanes: Vec<LaneGeometry>,
    areas: Vec<Area>,
}

impl SemanticMap {
    /// Checks the data and finds each lane's walls.
    pub fn new(data: &MapData) -> Result<Self, MapError> {
        unique("wall", data.walls.iter().map(|wall| &wall.id))?;
        unique("lane", data.lanes.iter().map(|lane| &lane.id))?;
        unique("area", data.areas.iter().map(|area| &area.id))?;
        for wall in &data.walls {
            check_length("wall", &wall.id, &wall.line)?;
        }
        let lanes = data
            .lanes
            .iter()
            .map(|lane| lane_geometry(lane, &data.walls))
            .collect::<Result<Vec<_>, _>>()?;
        let areas = data
            .areas
            .iter()
            .map(|area| resolve_area(area, &lanes))
            .collect::<Result<Vec<_>, _>>()?;
        Ok(Self { lanes, areas })
    }

    /// All lanes, in the order of the data.
    #[must_use]
    pub fn lanes(&self) -> &[LaneGeometry] {
        &self.lanes
    }

    /// All areas, in the order of the data.
    #[must_use]
    pub fn areas(&self) -> &[Area] {
        &self.areas
    }

    /// The index of the area called `id`.
    #[must_use]
    pub fn area_index(&self, id: &str) -> Option<usize> {
        self.areas.iter().position(|area| area.id == id)
    }

    /// The index of the first area that contains the point.
    #[must_use]
    pub fn area_at(&self, point: Point2) -> Option<usize> {
        self.areas
            .iter()
            .position(|area| area.region.contains(point))
    }
}

fn unique<'a>(
    kind: &'static str,
    ids: impl Iterator<Item = &'a String> + Clone,
) -> Result<(), MapError> {
    for (index, id) in ids.clone().enumerate() {
        if ids.clone().take(index).any(|earlier| earlier == id) {
            let id = id.clone();
            return Err(MapError::Duplicate { kind, id });
        }
    }
    Ok(())
}

fn check_length(kind: &'static str, id: &str, line: &Segment) -> Result<(), MapError> {
    if line.a.is_finite() && line.b.is_finite() && line.length_m() > 1e-6 {
        return Ok(());
    }
    let id = id.to_owned();
    Err(MapError::NoLength { kind, id })
}

fn resolve_area(area: &AreaData, lanes: &[LaneGeometry]) -> Result<Area, MapError> {
    for (what, found) in [
        ("speed limit", area.speed_limit_m_s),
        ("deviation limit", area.deviation_limit_m),
    ] {
        if !(found.is_finite() && found > 0.0) {
            let id = area.id.clone();
            return Err(MapError::Limit { id, what, found });
        }
    }
    let lane =
        match &area.lane {
            None => None,
            Some(name) => Some(lanes.iter().position(|lane| lane.id == *name).ok_or_else(
                || MapError::Unknown {
                    kind: "area",
                    id: area.id.clone(),
                    wanted: "lane",
                    name: name.clone(),
                },
            )?),
        };
    Ok(Area {
        id: area.id.clone(),
        region: area.region,
        lane,
        speed_limit_m_s: area.speed_limit_m_s,
        deviation_limit_m: area.deviation_limit_m,
    })
}

fn lane_geometry(lane: &LaneData, walls: &[WallData]) -> Result<LaneGeometry, MapError> {
    check_length("lane", &lane.id, &lane.line)?;
    let end = match &lane.end_wall {
        None => nearest_end(&lane.line, walls),
        Some(name) => {
            let index = walls
                .iter()
                .position(|wall| wall.id == *name)
                .ok_or_else(|| MapError::Unknown {
                    kind: "lane",
                    id: lane.id.clone(),
                    wanted: "wall",
                    name: name.clone(),
                })?;
            if distance_ahead_m(&lane.line, &walls[index].line).is_none() {
                return Err(MapError::NotAcross {
                    lane: lane.id.clone(),
                    wall: name.clone(),
                });
            }
            Some(index)
        }
    };
    Ok(LaneGeometry {
        id: lane.id.clone(),
        line: lane.line,
        direction_rad: lane.line.direction_rad(),
        left: nearest_beside(&lane.line, walls, 1.0),
        right: nearest_beside(&lane.line, walls, -1.0),
        end: end.map(|index| lane_wall(index, walls[index].line)),
    })
}

fn lane_wall(index: usize, line: Segment) -> LaneWall {
    LaneWall {
        index,
        line,
        direction_rad: line.direction_rad(),
    }
}

/// The nearest parallel wall to the left (`side` 1) or right (−1) that runs along the lane.
fn nearest_beside(lane: &Segment, walls: &[WallData], side: f64) -> Option<LaneWall> {
    let beside = |(index, wall): (usize, &WallData)| {
        let turned_rad = wrap_angle(wall.line.direction_rad() - lane.direction_rad()).abs();
        let line = if turned_rad > FRAC_PI_2 {
            Segment::new(wall.line.b, wall.line.a)
        } else {
            wall.line
        };
        let off_rad = wrap_angle(line.direction_rad() - lane.direction_rad()).abs();
        let middle = (line.a + line.b) * 0.5;
        let lateral_m = side * lane.lateral_m(middle);
        let from_m = lane.along_m(line.a).max(0.0);
        let to_m = lane.along_m(line.b).min(lane.length_m());
        let enough_m = OVERLAP_M.min(lane.length_m() / 2.0);
        (off_rad < PARALLEL_RAD
            && lateral_m > 0.0
            && lateral_m < BESIDE_M
            && to_m - from_m >= enough_m)
            .then(|| (lateral_m, lane_wall(index, line)))
    };
    walls
        .iter()
        .enumerate()
        .filter_map(beside)
        .min_by(|(one, _), (other, _)| one.total_cmp(other))
        .map(|(_, wall)| wall)
}

/// How far after the lane's start its line meets the wall.
fn distance_ahead_m(lane: &Segment, wall: &Segment) -> Option<f64> {
    let crossing_rad = wrap_angle(wall.direction_rad() - lane.direction_rad());
    if crossing_rad.sin().abs() < CROSSING_RAD.sin() {
        return None;
    }
    wall.ray_range_m(lane.a, lane.direction_rad())
}

fn nearest_end(lane: &Segment, walls: &[WallData]) -> Option<usize> {
    walls
        .iter()
        .enumerate()
        .filter_map(|(index, wall)| Some((distance_ahead_m(lane, &wall.line)?, index)))
        .filter(|&(ahead_m, _)| ahead_m <= lane.length_m() + AHEAD_M)
        .min_by(|(one, _), (other, _)| one.total_cmp(other))
        .map(|(_, index)| index)
}

#[cfg(test)]
mod tests;
