//! The rig: simulated devices, robots as processes, and a judge that believes the world and not the robot.
//!
//! - [`testbed`] puts a world and the devices of its robots together from the users' own files;
//! - [`robot`] starts a robot, this program with a hidden subcommand, as a process of its own;
//! - [`listener`] hears the robots on the network, as any third party could;
//! - [`judge`] finds laps and violations in the world's truth;
//! - [`lap`] is the scenario; [`summary`], [`report`] and [`progress`] are what it leaves and shows;
//! - [`devices`] runs the devices of one robot alone, for any other program.

pub mod cli;
pub mod devices;
pub mod judge;
pub mod lap;
pub mod listener;
pub mod process_usage;
pub mod progress;
pub mod report;
pub mod robot;
pub mod summary;
pub mod testbed;
