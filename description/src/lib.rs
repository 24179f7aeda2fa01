//! The words for robots, sites and motions that all crates share.
//!
//! * [`geometry`]: points, poses, twists, segments, rectangles, outlines;
//! * [`keys`]: how a key of a file is declared: type, unit, range, default and explanation in one place;
//! * [`names`]: what can stand in keys on the network;
//! * [`robot`], [`threads`]: what a robot file says;
//! * [`site`]: what a site file says;
//! * [`wheels`]: the speeds of the two hub wheels.
//!
//! Plain data: nothing here reads files, opens devices or knows a thread. Frames and units follow ROS REP 103 and
//! 105: x forward, y left, angles counter-clockwise, metres, radians, seconds.

pub mod geometry;
pub mod keys;
pub mod names;
pub mod robot;
pub mod site;
pub mod threads;
pub mod wheels;
