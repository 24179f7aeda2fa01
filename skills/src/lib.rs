//! Pure algorithms of one robot: no device, no file, no thread, no clock of their own.
//!
//! * [`odometry`], [`history`]: dead reckoning from wheel and pivot encoders, and its recent past;
//! * [`drive`]: motion commands to wheel setpoints;
//! * [`scan`]: range scans, aligned to the motion during the sensor's turn;
//! * [`perception`]: corridor and lane end, found and tracked in scans;
//! * [`localisation`]: the pose in `map`;
//! * [`control`], [`monitors`]: controllers and the conditions that raise events;
//! * [`borders`]: how far the robot may go until its footprint enters an area that it has no leave for;
//! * [`map`], [`schedule`]: the semantic map, and what runs in each state of the robot's machine;
//! * [`navigator`]: all of this as one step.
//!
//! **Real time.** What is built once may allocate while it is built; every step afterwards does not allocate, lock, log,
//! wait or make a system call.

pub mod borders;
pub mod control;
pub mod drive;
pub mod history;
pub mod localisation;
pub mod map;
pub mod monitors;
pub mod navigator;
pub mod odometry;
pub mod perception;
pub mod scan;
pub mod schedule;
pub mod tubes;
