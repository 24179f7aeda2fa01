//! Trials: what a robot must do and must not do in a course, judged by the world's truth.
//!
//! - [`Judge`] sees true states, the site's map, and what the robot believes, which it only compares with the truth;
//! - [`LeaveKeeper`] withholds leave for areas, as a mediator would that has promised them to others;
//! - [`insight`] reads what a running robot believes;
//! - a [`Scenario`](scenario::Scenario) says how the world is furnished and when the trial is done: [`course`], [`clutter`];
//! - an [`Operator`](operator::Operator) gives the events that nothing on the robot raises;
//! - [`view`] says which walls a robot can see.

pub mod clutter;
pub mod course;
mod figures;
pub mod insight;
mod judge;
mod leave;
pub mod operator;
mod overlap;
pub mod scenario;
mod stops;
pub mod view;

pub use figures::Figures;
pub use judge::{Judge, Look, Rules};
pub use leave::LeaveKeeper;
pub use stops::{StopError, StopKind};
