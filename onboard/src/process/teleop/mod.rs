//! `onboard teleop` on the robot's side: the desk at which one teleoperator sits, on a thread of its own.
//!
//! The supervisor takes the robot into somebody's hands and out of them, as a level: the session's number in the symbol
//! `robot_mode`. The desk hears the wishes of that session and writes the newest one, with the time at which it was heard,
//! as the symbol `teleop_wish`; navigation drives it while it is fresh. So a wish reaches the robot without waiting for the
//! supervisor, and whatever hangs or ends, the robot stops:
//!
//! | what | who notices | after |
//! |---|---|---|
//! | the dead-man is let go | the program at the desk's other end, which says so | at once |
//! | the connection closes, as when that program is killed | the desk | at once |
//! | no wish comes | navigation, by the wish's age | `teleop.deadline_ms` |
//! | the desk's thread hangs | navigation; then the supervisor takes the robot back | the same; 1 s |
//! | the supervisor hangs | the motion tube | 1 s |
//!
//! On the socket, after the robot's first line, go lines `FORWARD_M_S TURN_RAD_S` one way and a [`Status`] as JSON, ten
//! times a second, the other way. The last one may be [`Over`] instead.
//!
//! **Armed.** A wish to move counts only after one to stand that came when nothing kept the robot from driving. So a robot
//! whose fault is reset does not start because somebody still holds the dead-man.

mod desk;
mod status;
mod thread;

pub use desk::{Desk, Over};
pub use status::Status;
pub use thread::{BEAT_NS, spawn};
