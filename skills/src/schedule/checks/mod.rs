//! Whether skills, states and turns make sense together, on this map and for this robot.
//!
//! Schedules can be made of more than a robot can drive: a state whose event can never occur, a turn that begins beside its
//! area, a body that reaches over the border. [`check`] finds these in the files, before anything moves.

mod findings;
mod judge;
mod perception;
mod reach;
mod role;
mod states;
mod turns;
mod waiting;
mod width;

pub use judge::check;
pub use reach::RobotReach;
