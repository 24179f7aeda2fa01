//! The semantic map: walls, directed lanes and areas, built from plain data and checked.
//!
//! A lane knows the walls that perception should expect beside it and at its end. Everything is in the `map` frame.
//!
//! ```
//! use description::geometry::{Point2, Rect, Segment};
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

mod lane;

use crate::borders::MAX_AREAS;
use description::geometry::{Point2, Pose2, Rect, Segment, wrap_angle};
use lane::lane_geometry;

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
    /// The nearest wall to the left that runs along a good part of the lane.
    pub left: Option<LaneWall>,
    /// The same to the right.
    pub right: Option<LaneWall>,
    /// All pieces of wall that face the lane from the left, from its start to its end; between them it is open.
    pub left_walls: Vec<LaneWall>,
    /// The same from the right.
    pub right_walls: Vec<LaneWall>,
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
    /// An area's corners are in the wrong order, or a number is not finite.
    #[error("area `{id}` must have finite corners, the smaller coordinates first")]
    Region {
        /// The area.
        id: String,
    },
    /// More areas than a set of areas holds.
    #[error("{found} areas; expected at most {MAX_AREAS}")]
    TooManyAreas {
        /// Found.
        found: usize,
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

/// A straight wall as navigation uses it.
#[derive(Clone, Debug, PartialEq)]
pub struct Wall {
    /// Name.
    pub id: String,
    /// Where it is.
    pub line: Segment,
    /// Direction of `line`.
    pub direction_rad: f64,
}

/// The map, checked, with everything resolved.
#[derive(Clone, Debug, PartialEq)]
pub struct SemanticMap {
    walls: Vec<Wall>,
    lanes: Vec<LaneGeometry>,
    areas: Vec<Area>,
}

impl SemanticMap {
    /// Checks the data and finds each lane's walls.
    pub fn new(data: &MapData) -> Result<Self, MapError> {
        unique("wall", data.walls.iter().map(|wall| &wall.id))?;
        unique("lane", data.lanes.iter().map(|lane| &lane.id))?;
        unique("area", data.areas.iter().map(|area| &area.id))?;
        if data.areas.len() > MAX_AREAS {
            let found = data.areas.len();
            return Err(MapError::TooManyAreas { found });
        }
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
        let walls = data.walls.iter().map(|wall| Wall {
            id: wall.id.clone(),
            line: wall.line,
            direction_rad: wall.line.direction_rad(),
        });
        Ok(Self {
            walls: walls.collect(),
            lanes,
            areas,
        })
    }

    /// All walls, in the order of the data.
    #[must_use]
    pub fn walls(&self) -> &[Wall] {
        &self.walls
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
    let size = area.region.max - area.region.min;
    if !(size.is_finite() && size.x_m >= 0.0 && size.y_m >= 0.0) {
        let id = area.id.clone();
        return Err(MapError::Region { id });
    }
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

#[cfg(test)]
mod tests;
