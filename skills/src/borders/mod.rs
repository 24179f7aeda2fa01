//! Borders of areas: how far the robot may go until its footprint would enter an area that is not allowed.
//!
//! [`BorderGuard`] follows a path ahead of the robot and finds the first place where the footprint, grown by the
//! uncertainty of the pose and a margin, would touch an area outside the allowed set. Growth is by direction: a pose
//! that is uncertain along a corridor does not keep the robot away from the lane beside it. The answer is on the safe
//! side: never late, and at most a few millimetres early.
//!
//! Guaranteed: while the pose's true error stays within the configured number of standard deviations (of x, y and θ
//! together) and the robot stays on the path, no part of the footprint enters a forbidden area before the distance told.
//!
//! Real time: judging a path neither allocates nor locks nor panics, and does a bounded amount of work.
//!
//! ```
//! use nalgebra::Matrix3;
//! use description::areas::AreaIndex;
//! use skills::borders::{AreaSet, BorderGains, BorderGuard, Curve};
//! use description::geometry::{Footprint, Point2, Pose2, Rect};
//! let ahead = Rect::new(Point2::new(2.0, -1.0), Point2::new(4.0, 1.0));
//! let footprint = Footprint { front_m: 0.32, rear_m: 0.08, left_m: 0.15, right_m: 0.15 };
//! let guard = BorderGuard::new(vec![ahead], footprint, BorderGains::default());
//! let known_well = Matrix3::identity() * 1e-6;
//! let curve = Curve { curvature_1_m: 0.0, reach_m: 3.0 };
//! let judged = guard.along_curve(&AreaSet::EMPTY, Pose2::IDENTITY, &known_well, curve);
//! assert_eq!(judged.area, Some(AreaIndex(0)));
//! assert!((judged.distance_m - 1.66).abs() < 0.02);
//! assert!(guard.along_curve(&AreaSet::ALL, Pose2::IDENTITY, &known_well, curve).area.is_none());
//! ```

mod guard;
mod set;

pub use guard::{BorderGains, BorderGuard, BorderVerdict, Curve};
pub use set::AreaSet;

#[cfg(test)]
mod tests;
