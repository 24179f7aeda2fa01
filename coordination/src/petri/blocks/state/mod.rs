//! What changes while a net runs.

mod fire;
mod net_state;
mod search;

pub(in crate::petri) use net_state::State;
