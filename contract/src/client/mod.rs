//! The robot's side of its protocols, without network, clock or floor: what to ask for, what is granted, what is ordered.
//!
//! A robot tells a [`Client`] where it stands and where it wants to go ([`Client::step`]), hands it what the mediator says
//! ([`Client::receive`]), sends what [`Client::report`] gives, and keeps out of every area that it [may not be
//! in](Client::may_be_in).
//!
//! While it [is acquired](Client::is_acquired), its state machine does nothing by itself: it gets the events of
//! [orders](Client::next_order), and [what it outputs](Client::output) tells the mediator how far it is. The client then asks
//! for no areas but those that the robot stands in, cannot avoid any more, or was ordered to enter.
//!
//! Allocates; not for real-time threads.

mod access;
mod control;
mod others;
mod revocation;
mod robot;
mod session;
mod situation;

pub use control::Order;
pub use robot::Client;
pub use session::{EPOCH_STEP, LAST_NUMBER, Received, SEQUENCE_STEP, is_reached_from};
pub use situation::{ClientCounters, Situation};

#[cfg(test)]
mod tests;
