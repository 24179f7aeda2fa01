//! The rig: simulated devices, robots as processes, and a judge that believes the world and not the robot.
//!
//! - [`testbed`] puts a world and the devices of its robots together from the users' own files;
//! - [`process`] starts this program as another; [`robot`] starts a robot, this program with a hidden subcommand, as a process of its own;
//! - [`listener`] hears the robots on the network, as any third party could;
//! - [`judge`] finds laps and violations in the world's truth;
//! - [`stage`] is all of these for one robot; [`lap`] a scenario on it;
//! - [`trial`] judges what robots do in a course; [`trials`] runs such trials [`live`](mod@live) on a stage, or
//!   [`stepped`] on a simulated clock, and then by the thousand in a [`campaign`](mod@campaign)
//!   with [`statistics`];
//! - [`summary`], [`report`] and [`progress`] are what they leave and show;
//! - [`map`](mod@map) draws a site file;
//! - [`fleet`] runs scenarios with several robots and a mediator;
//! - [`devices`] runs the devices of one robot alone, for any other program.

pub mod campaign;
pub mod cli;
pub mod devices;
pub mod fleet;
pub mod folder;
pub mod judge;
pub mod lap;
pub mod listener;
pub mod live;
pub mod map;
pub mod process;
pub mod process_usage;
pub mod progress;
pub mod report;
pub mod robot;
pub mod stage;
pub mod statistics;
pub mod stepped;
pub mod summary;
pub mod testbed;
pub mod trial;
pub mod trials;
