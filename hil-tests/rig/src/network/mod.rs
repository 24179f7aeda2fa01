//! What is said on the network: an independent listener, what follows from what it hears, and the mediator's own word.

pub mod endpoint;
pub mod listener;
pub mod mediator_status;
pub mod observations;
