//! `onboard ctl`: requests to a running robot over its control socket.
//!
//! One connection carries one line there, the request's name (after `send` the event as JSON), and text back: what was
//! done, or `refused: WHY`.

mod pending;
mod reply;
mod request;
mod socket;

pub use pending::Pending;
pub(crate) use reply::quoted;
pub use reply::{Done, Refusal, Reply};
pub use request::{Event, Request};
pub use socket::{Server, send};
