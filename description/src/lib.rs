//! The vocabulary for robots, sites and motions that all crates share, as plain data.
//!
//! * [`areas`]: areas of a site by number;
//! * [`endpoints`]: endpoints of the fleet's network;
//! * [`geometry`]: points, poses, twists, segments, rectangles, outlines;
//! * [`instruction`]: events for a state machine, with parameters;
//! * [`keys`]: how a key of a file is declared: type, unit, range, default and explanation in one place;
//! * [`names`]: what can stand in keys on the network;
//! * [`robot`], [`threads`]: what a robot file says;
//! * [`site`]: what a site file says;
//! * [`wheels`]: the speeds of the two hub wheels.
//!
//! Nothing here reads files, opens devices or knows a thread. Frames and units follow ROS REP 103 and 105: x forward, y
//! left, angles counter-clockwise, metres, radians, seconds.
//!
//! # Example
//! Where the front left corner of a robot gets to in half a second of a curve to the left; and a gain out of its range.
//! ```
//! use description::geometry::{Footprint, MotionCommand, Pose2};
//! use description::keys::Section;
//! use description::robot::Control;
//!
//! let footprint = Footprint { front_m: 0.32, rear_m: 0.08, left_m: 0.15, right_m: 0.15 };
//! let curve = MotionCommand::new(0.4, 0.5);
//! let pose = Pose2::new(1.0, 2.0, 0.0).advance(curve.twist(), 0.5);
//! let corner = pose.transform(footprint.corners()[0]);
//! assert!((corner.x_m - 1.503).abs() < 1e-3 && (corner.y_m - 2.191).abs() < 1e-3);
//!
//! let error = Control { pivot_gain_1_s: -1.0, ..Control::default() }.check().unwrap_err();
//! assert_eq!(error.key, "pivot_gain_1_s");
//! ```

/// The metamodel of what a robot's activities share and other programs read: one plain value of a fixed layout, with a monotonic
/// stamp in nanoseconds. Names of values end with their unit (`_m`, `_rad`, `_m_s`, `_s`); poses are in `map` or `odom`, what moves with the
/// robot in `base_link`, as the value's type says; frames are those of this crate.
pub const SYMBOLS: &str = "urn:kelo-onboard:symbols:1";

pub mod areas;
pub mod endpoints;
pub mod geometry;
pub mod instruction;
pub mod keys;
pub mod names;
pub mod robot;
pub mod site;
pub mod threads;
pub mod wheels;
