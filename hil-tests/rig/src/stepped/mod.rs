//! Robots on a simulated clock: no threads, no devices, hundreds of times faster than real time.
//!
//! The activities are the robot's own, the very ones that its threads run, with their symbols between them, stepped in
//! the order and with the periods of its thread table. Simulated are the two ends of the circle: [`drive`] stands for
//! the drive activity with bus and wheel unit, [`lidar`] for the lidar activity with the sensor and its serial line. In
//! the supervisor's place a [`supervisor`](self::supervisor) brings the activities to life and takes down what they report.
//! Where the rig withholds leave for areas, [`leave`] tells navigation so in the place of communication.
//!
//! [`Stepped`] runs the robots of a scenario so, for [`Run`](crate::run::Run) to judge; [`SteppedRobot`] is one robot.
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
