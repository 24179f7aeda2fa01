//! Robots on a simulated clock: no threads, no devices, hundreds of times faster than real time.
//!
//! The activities are the robot's own, the very ones that its threads run (but for [`navigation`] where leave for areas
//! is withheld, which the robot's own knows nothing of), with their symbols between them, stepped in
//! the order and with the periods of its thread table. Simulated are the two ends of the circle: [`drive`] stands for
//! the drive activity with bus and wheel unit, [`lidar`] for the lidar activity with the sensor and its serial line. In
//! the supervisor's place a [`director`](self::director) brings the activities to life and takes down what they report.
//!
//! The same seed gives the same run. What real threads add (late wake-ups, lost frames, broken scans) is left to the
//! runs through the real programs.

mod director;
mod drive;
mod lidar;
mod navigation;
mod robot;
mod run;

pub use director::Note;
pub use robot::{SteppedRobot, send};
pub use run::{Outcome, Setup, Trace, run};
