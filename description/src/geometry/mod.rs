//! Plane geometry that all skills share.
//!
//! Frames and units follow REP 103: x forward, y left, angles counter-clockwise, metres, radians, seconds.
//! Plain `Copy` values; nothing here allocates, locks or panics, so all of it may run in a real-time thread.
//!
//! ```
//! use description::geometry::{Point2, Pose2};
//! let laser_in_base = Pose2::new(0.28, 0.0, 0.0);
//! let point = laser_in_base.transform(Point2::new(1.0, 0.5));
//! assert!((point.x_m - 1.28).abs() < 1e-12);
//! ```

mod fields;
mod motion;
mod shape;

pub use motion::{MotionCommand, Point2, Pose2, Twist2, wrap_angle};
pub use shape::{Footprint, Rect, Segment};

#[cfg(test)]
mod tests;
