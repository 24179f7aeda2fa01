//! The semantic map: walls, directed lanes and areas, built from a site and checked.
//!
//! A lane knows the walls that perception should expect beside it and at its end. Everything is in the `map` frame.
//!
//! ```
//! use description::geometry::{Point2, Rect, Segment};
//! use description::site::{Lane, Site, Wall};
//! use skills::map::SemanticMap;
//! let wall = |id: &str, x0, y0, x1, y1| Wall {
//!     id: id.into(),
//!     line: Segment::new(Point2::new(x0, y0), Point2::new(x1, y1)),
//! };
//! let map = SemanticMap::new(&Site {
//!     walls: vec![wall("south", 0.0, -1.6, 10.0, -1.6), wall("east", 10.0, -1.6, 10.0, 1.6)],
//!     lanes: vec![Lane {
//!         id: "out".into(),
//!         line: Segment::new(Point2::new(1.0, -0.5), Point2::new(9.0, -0.5)),
//!         end_wall: Some("east".into()),
//!     }],
//!     ..Site::default()
//! })?;
//! let lane = &map.lanes()[0];
//! assert!(lane.left.is_none() && lane.right.is_some() && lane.end.is_some());
//! # Ok::<(), description::keys::KeyError>(())
//! ```

mod lane;
mod semantic_map;

pub use lane::{LaneGeometry, LaneWall};
pub use semantic_map::{Area, SemanticMap, Wall};

#[cfg(test)]
mod tests;
