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

mod data;
mod error;
mod lane;
mod semantic_map;

pub use data::{AreaData, LaneData, MapData, WallData};
pub use error::MapError;
pub use lane::{LaneGeometry, LaneWall};
pub use semantic_map::{Area, SemanticMap, Wall};

#[cfg(test)]
mod tests;
