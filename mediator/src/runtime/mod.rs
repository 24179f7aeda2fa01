//! The running mediator: two activities on two threads, and what waits between them, bounded in each direction.
//!
//! *Management* owns manager and journal, and takes one step after the other; [`Turn`] is that step, without thread and
//! clock, so that it also runs on a simulated one. *Communication* owns the network and
//! the control socket. Reports wait in [`Waiting`], where the newest counts; a full queue of messages drops what came last and
//! counts it: levels are repeated.

mod afar;
mod checked;
mod communication;
mod files;
mod folder;
mod inbox;
mod input;
mod management;
mod mediators;
mod network;
mod orders;
mod question;
mod repeats;
mod shared;
mod threads;
mod turn;
mod turning;
mod waiting;

pub use afar::ask_from_afar;
pub use checked::report_in;
pub use folder::Folder;
pub use input::{Asked, Asker, Input, Reply, Ticket};
pub use management::{Management, TICK_NS};
pub use network::Settings;
pub use question::{Answer, Question, ask};
pub use shared::Shared;
pub use threads::{OUTPUTS, Runtime};
pub use turn::{Sent, Turn};
pub use waiting::Waiting;
