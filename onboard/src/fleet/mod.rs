//! The robot's side of the mediator: areas and orders, without network, clock or threads.
//!
//! A [`Member`] hears the mediator and senses where the robot is; it says which areas navigation may use, what navigation is
//! ordered to do, and what to report. Protocols are `contract::client`'s; here is what they mean on the floor: which areas
//! the footprint reaches into, which the next manoeuvres take and when to ask for them, which can no longer be stopped
//! before. Allocates; not for real-time threads.

mod floor;
mod member;
mod needs;
mod orders;
mod origin;
mod route;
mod sense;
mod setup;
#[cfg(test)]
mod tests;

pub use floor::{LEAVING_M, UncertainPose};
pub use member::Member;
pub use orders::Directive;
pub use sense::{Sense, Troubles};
pub use setup::{AreaPlace, Began, LEAVE_AGE_NS, Setup, Start, StatePlan, Stood};
