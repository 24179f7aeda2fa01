//! The supervisor: life cycles, faults, signals, requests and the log, ten times a second on the main thread.
//!
//! It runs no activity. It tells activities what to do by events and learns of them by reports; what they do meanwhile
//! does not wait for it.

mod ending;
mod handles;
mod holders;
mod inheritance;
mod keeper;
mod lease;
mod lending;
mod moved;
mod requests;
mod sent;
mod sleep;
mod supervision;
mod waiting;

pub use ending::{Ending, STOPPING_NS, UNSUPERVISED_NS};
pub use handles::{Handle, ports};
pub use keeper::Keeper;
pub use supervision::{PERIOD_NS, Supervisor};
