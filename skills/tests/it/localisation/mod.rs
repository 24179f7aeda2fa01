//! The pose in `map` against the truth: a light simulation of odometry and lidar among the walls of the reference maps.
//!
//! Odometry is wrong by up to one per cent in distance and turning and bends; ranges scatter by ten millimetres or one
//! per cent; each beam is measured where the robot was at its time. A driver who sees the truth follows the way, so that
//! the pose alone is judged.

mod accuracy;
mod consistency;
mod doubt;
mod floor;
mod fuzz;
mod maps;
mod obstacles;
mod run;
mod timing;
