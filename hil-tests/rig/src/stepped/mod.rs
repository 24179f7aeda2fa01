//! Robots on a simulated clock: no threads, no devices, hundreds of times faster than real time.
//!
//! The activities are those that the robot's threads run, with their symbols between them, stepped in the order and with
//! the periods of its thread table. Only the ends of the loop are simulated: `drive` stands in for the drive activity
//! with bus and wheel unit, `lidar` for the lidar activity with the sensor and its serial line,
//! `supervisor` for the supervisor: it brings the activities to life and records what they report.
//! Where the rig withholds leave for areas, `leave` stands in for communication.
//!
//! [`Stepped`] runs the robots of a scenario this way, for [`Run`](crate::run::Run) to judge; [`SteppedRobot`] is one robot.
//!
//! The same seed gives the same run. What real threads add (late wake-ups, lost frames, broken scans) is left to the
//! runs through the real programs.

mod clock;
mod drive;
mod execution;
mod leave;
mod lidar;
mod robot;
mod supervisor;
mod trace;

pub use execution::{Plans, Stepped};
pub use robot::SteppedRobot;
pub use supervisor::Note;
pub use trace::Trace;
