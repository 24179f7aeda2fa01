//! The words for robots, sites and motions that all crates share.
//!
//! Plain data: nothing here reads files, opens devices or knows a thread. Frames and units follow ROS REP 103 and
//! 105: x forward, y left, angles counter-clockwise, metres, radians, seconds.

pub mod geometry;
pub mod wheels;
