//! The rig: simulated devices, robots and the mediator as processes, and a judge that believes the world and not the robot.
//!
//! - [`testbed`] puts a world and the devices of its robots together from the users' own files;
//! - [`process`] starts this program as another: robots and the mediator are this program with a hidden subcommand;
//! - [`network`] hears robots and mediator, as any third party could; [`belief`] is what a robot believes;
//! - [`scenario`] is what a scenario file says, [`goals`] how far robots are with it, [`stand_ins`] play operators;
//! - [`judge`] finds violations in the world's truth;
//! - [`run`] is one run of a scenario through the real programs, [`stepped`] on a simulated clock, [`campaign`] many of them;
//! - [`record`] is all that is known of a run, [`summary`] its figures, [`report`] its drawings;
//! - [`map`](mod@map) draws a site file; [`devices`] runs the devices of one robot alone, for any other program.

pub mod belief;
pub mod campaign;
pub mod cli;
pub mod commands;
pub mod devices;
pub mod folder;
pub mod goals;
pub mod judge;
pub mod map;
pub mod network;
pub mod one_robot;
pub mod process;
pub mod record;
pub mod report;
pub mod run;
pub mod scenario;
pub mod stand_ins;
pub mod stepped;
pub mod summary;
pub mod testbed;
