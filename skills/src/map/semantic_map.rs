//! The map, checked, with everything resolved.

use super::data::{AreaData, MapData};
use super::error::{MapError, check_length};
use super::lane::{LaneGeometry, lane_geometry};
use crate::borders::MAX_AREAS;
use description::geometry::{Point2, Rect, Segment};

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
    ///
    /// # Errors
    /// The first [`MapError`] in the data.
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
