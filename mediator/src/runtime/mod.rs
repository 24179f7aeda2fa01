//! The running mediator: two activities on two threads, and a bounded queue in each direction between them.
//!
//! *Management* owns manager and journal, and takes one step after the other; [`Management`] is that step, without thread and
//! clock, so that it also runs on a simulated one. *Communication* owns the network and
//! the control socket. A full queue drops what came last and counts it: levels are repeated.

mod communication;
mod folder;
mod management;
mod question;
mod shared;
mod threads;

pub use communication::{Settings, report_in};
pub use folder::Folder;
pub use management::{BATCH, Input, Management, TICK_NS};
pub use question::{Answer, Question, ask};
pub use shared::Shared;
pub use threads::{INPUTS, OUTPUTS, Runtime};
