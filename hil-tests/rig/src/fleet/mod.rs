//! Scenarios with a fleet: world and devices of several robots, every robot and the mediator a process of its own.
//!
//! - [`record`] is all that is known of a run when it is over, [`summary`] its figures.

pub mod record;
pub mod scenario;
pub mod summary;
