//! Schedules: what runs in each state of the robot's machine.
//!
//! A *skill* joins perception, one controller and monitors. A *schedule* is a skill bound to one state: its area's limits,
//! the lane it drives on, the walls it expects. [`compile`] makes one schedule for each state and derives what the
//! data leave out: the lanes that a turn leads from and to, and the speed to have at a lane's end, follow from the machine's
//! transitions. It checks that each manoeuvre can be driven by the robot in the map: curves that fit between their lanes,
//! walls that are there to dock at, borders that lie ahead. Changing the state changes the schedule, at run time, without
//! allocation.
//!
//! [`check`] judges what a schedule could be made of and would still be a mistake: states whose skill perceives too little,
//! turns that begin beside their area, bodies that reach over a border.

mod checks;
mod compile;
pub(crate) mod controllers;
mod graph;
mod room;
mod state_schedule;

pub use checks::{RobotReach, check};
pub use compile::{compile, machine};
pub use controllers::case::RobotLimits;
pub use controllers::{Controller, Corridor, CreepBy, Dock, Hold, Shift, StopAt, Turn, UTurn};
pub use state_schedule::Schedule;

#[cfg(test)]
mod tests;
