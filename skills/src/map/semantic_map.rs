//! The map, checked, with everything resolved.

use super::lane::{LaneGeometry, lane_geometry};
use description::areas::{AreaIndex, MAX_AREAS};
use description::geometry::{Point2, Rect, Segment};
use description::keys::{KeyError, Section};
use description::site::{self, Site};

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
    /// Checks the site's walls, lanes and areas, and finds each lane's walls.
    ///
    /// # Errors
    /// The first key of the site that does not fit.
    pub fn new(site: &Site) -> Result<Self, KeyError> {
        unique("walls", site.walls.iter().map(|wall| &wall.id))?;
        unique("lanes", site.lanes.iter().map(|lane| &lane.id))?;
        unique("areas", site.areas.iter().map(|area| &area.id))?;
        if site.areas.len() > MAX_AREAS {
            let found = format!("{} areas", site.areas.len());
            return Err(KeyError::new(
                "areas",
                found,
                format!("at most {MAX_AREAS}"),
            ));
        }
        for wall in &site.walls {
            check_line("walls", &wall.id, wall, &wall.line)?;
        }
        for lane in &site.lanes {
            check_line("lanes", &lane.id, lane, &lane.line)?;
        }
        let lanes = site.lanes.iter();
        let lanes = lanes.map(|lane| lane_geometry(lane, &site.walls));
        let lanes = lanes.collect::<Result<Vec<_>, _>>()?;
        let areas = site.areas.iter().map(|area| resolve_area(area, &lanes));
        let areas = areas.collect::<Result<Vec<_>, _>>()?;
        let walls = site.walls.iter().map(|wall| Wall {
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

    /// All walls, in the order of the site.
    #[must_use]
    pub fn walls(&self) -> &[Wall] {
        &self.walls
    }

    /// All lanes, in the order of the site.
    #[must_use]
    pub fn lanes(&self) -> &[LaneGeometry] {
        &self.lanes
    }

    /// All areas, in the order of the site.
    #[must_use]
    pub fn areas(&self) -> &[Area] {
        &self.areas
    }

    /// An area of this map.
    #[must_use]
    pub fn area(&self, index: AreaIndex) -> &Area {
        &self.areas[index.place()]
    }

    /// The area called `id`.
    #[must_use]
    pub fn area_index(&self, id: &str) -> Option<AreaIndex> {
        self.find(|area| area.id == id)
    }

    /// The first area that contains the point.
    #[must_use]
    pub fn area_at(&self, point: Point2) -> Option<AreaIndex> {
        self.find(|area| area.region.contains(point))
    }

    fn find(&self, fits: impl FnMut(&Area) -> bool) -> Option<AreaIndex> {
        self.areas.iter().position(fits).and_then(AreaIndex::new)
    }
}

fn unique<'a>(
    section: &str,
    ids: impl Iterator<Item = &'a String> + Clone,
) -> Result<(), KeyError> {
    for (index, id) in ids.clone().enumerate() {
        if ids.clone().take(index).any(|earlier| earlier == id) {
            let found = format!("`{id}` a second time");
            return Err(KeyError::new(section, found, "each name once"));
        }
    }
    Ok(())
}

fn check_line(
    section: &str,
    id: &str,
    value: &impl Section,
    line: &Segment,
) -> Result<(), KeyError> {
    let key = format!("{section}.{id}");
    value.check().map_err(|error| error.below(&key))?;
    if line.length_m() > 1e-6 {
        return Ok(());
    }
    let found = format!("a length of {} m", line.length_m());
    Err(KeyError::new(key, found, "a length above zero"))
}

fn resolve_area(area: &site::Area, lanes: &[LaneGeometry]) -> Result<Area, KeyError> {
    let key = format!("areas.{}", area.id);
    area.check().map_err(|error| error.below(&key))?;
    let lane = area.lane.as_ref().map(|name| {
        let lane = lanes.iter().position(|lane| lane.id == *name);
        lane.ok_or_else(|| KeyError::unknown(format!("{key}.lane"), "lane", name))
    });
    Ok(Area {
        id: area.id.clone(),
        region: area.region,
        lane: lane.transpose()?,
        speed_limit_m_s: area.control.speed_limit_m_s,
        deviation_limit_m: area.control.deviation_limit_m,
    })
}
