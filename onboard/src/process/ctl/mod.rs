//! `onboard ctl`: requests to a running robot over its control socket.
//!
//! One connection carries one line there, the request's name (with its parameters as JSON, if it has any), and text back: what was
//! done, or `refused: WHY`. Only that of `teleop` stays: see [`crate::process::teleop`].

mod pending;
mod reply;
mod request;
mod socket;

pub use pending::Pending;
pub(crate) use reply::quoted;
pub use reply::{Done, Placement, Refusal, Reply};
pub use request::{Event, FreeBehind, Place, Request, Spot, Teleop};
pub use socket::{Guest, Server, ask, begin, send};
