//! Robots on a simulated clock: no threads, no devices, hundreds of times faster than real time.
//!
//! The activities are those that the robot's threads run, with their symbols between them and their supervisor, stepped in the
//! order and with the periods of its thread table; the mediator's area management runs with its journal, as on its own thread.
//! Simulated are the ends: `drive` stands in for the drive activity with bus and wheel unit, `lidar` for the lidar activity
//! with the sensor and its serial line, `network` for zenoh, and memory for the journal's disk.
//! Where the rig withholds leave for areas, `leave` stands in for communication.
//!
//! [`Stepped`] runs the robots of a scenario this way, for [`Run`](crate::run::Run) to judge; [`SteppedRobot`] is one robot.
//!
//! The same seed gives the same run. [`faults`] come from the scenario or are drawn from the seed: messages, processes, the disk
//! and operators. What goes wrong on buses and lines (lost frames, broken scans) is left to the runs through the real programs.

mod clock;
mod disk;
mod drive;
mod execution;
pub mod faults;
mod fleet;
mod injection;
mod leave;
mod lidar;
mod mediator;
mod network;
mod plans;
mod robot;
mod trace;

pub use fleet::Stepped;
pub use plans::Plans;
pub use robot::{Fleet, Start, SteppedRobot};
pub use trace::Trace;
