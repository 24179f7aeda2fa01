//! A net closed with its protocols: its states and the steps between them.

mod build;
mod describe;
mod faults;
mod net;
mod steps;

pub(super) use net::{Closed, Move};
