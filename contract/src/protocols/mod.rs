//! The protocols that robots and mediator run, as flag arrays.
//!
//! [`access`] and [`revocation`] are the same for every robot and area. [`control_paths`] is made for each coordination from the
//! flags of its net's file, which the mediator sends along, so that a robot needs to know no net.

mod access;
mod control;
mod model;
mod names;
mod revocation;

pub use access::{AccessProtocol, access};
pub use control::{ControlError, control, control_paths, flags_and_paths};
pub use model::begin;
pub use names::*;
pub use revocation::{RevocationProtocol, revocation};

#[cfg(test)]
mod tests;
