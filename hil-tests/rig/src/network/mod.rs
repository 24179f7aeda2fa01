//! What is said on the network: an independent listener, what it concludes, and the mediator's own status.

pub mod endpoint;
pub mod listener;
pub mod mediator_status;
pub mod observations;
