//! Coordinations: which nets run, with which robots, and which areas they keep for them.
//!
//! A net starts when a situation of its plan has come, takes the discrete control of its robots, keeps areas for them, and ends
//! when all have it back. One that stands still raises an alarm, and has its robots get out of the way where its plan says so.
//! An area that a net governs is entered only when the net says so; a robot whose discrete control is taken gets only the areas
//! of its orders, and before everybody else.

mod answer;
mod answers;
mod candidates;
mod control;
mod judging;
mod running;
mod situations;
mod status;
mod steps;
mod surroundings;
mod watch;

pub(crate) use running::Coordinations;
pub use status::CoordinationStatus;
pub(crate) use surroundings::Surroundings;
