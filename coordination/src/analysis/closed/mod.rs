//! A net closed with its protocols: its states and the steps between them.

mod build;
mod describe;
mod faults;
mod net;
#[cfg(feature = "symbolic")]
mod parts;
#[cfg(feature = "symbolic")]
pub(super) mod rule;
#[cfg(feature = "symbolic")]
mod rules;
mod steps;

pub(super) use net::{Closed, Move};
