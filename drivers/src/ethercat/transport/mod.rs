//! Carries the frames of ethercrab's futures over a link, each with a number that its answer must bring back.

mod channel;
mod counters;
mod pump;
mod seal;

pub use channel::Channel;
pub use counters::BusCounters;
pub use pump::{Patience, Pump, Resend, Stopped};
