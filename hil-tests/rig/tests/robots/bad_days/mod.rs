//! Bad days, through the real programs: the robot is a process, its devices speak their protocols, and what happened
//! is judged by the world's truth.
//!
//! - [`bench`] puts world, devices and robot up; [`watch`] waits for and judges what is true; [`figures`](crate::figures) asks how its
//!   threads do, and [`held`](crate::held) keeps one from its work; [`turn`](crate::turn) lets robots run one for each core;
//!   [`late`](crate::late) knows when the machine was to blame;
//! - [`lidar`], [`bus`], [`drive`]: devices and the world misbehave;
//! - [`death`]: the robot is killed or told to end; [`names`]: what it needs is taken; [`files`]: its files are wrong;
//! - [`operator`], [`orders`]: requests while it drives; [`by_hand`]: somebody drives it; [`doors`]: other users ask;
//! - [`rules`]: what its real-time threads promise, for a minute;
//! - [`laps`]: the rig itself is interrupted or killed; [`overload`]: the computer has no time for it.
//!
//! Here is what only real programs show, and that they are safe; what they make of faults is judged in `tests/stepped`.

mod bench;
mod bus;
mod by_hand;
mod death;
mod doors;
mod drive;
mod files;
mod laps;
mod lidar;
mod names;
mod operator;
mod orders;
mod overload;
mod rules;
mod watch;
