//! What changes while a net runs.

mod fire;
mod net_state;
mod ports;
mod search;

pub(super) use fire::Allowance;
pub(super) use net_state::State;
pub(super) use ports::Ports;
