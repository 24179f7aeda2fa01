//! Who speaks for a robot: identity, registration, restarts, silence.
//!
//! * **Identity.** The site lists its robots; nobody else gets anything but a refusal.
//! * **Boot and session.** One process at a time speaks for a robot. While it is heard, any other one is refused: it restarted a
//!   moment ago, or two robots have one identity. Once it is silent, another one that reports is a *candidate*: it speaks when
//!   it has repeated the session number that it was offered. So a late message of a dead process takes nothing from anybody.
//! * **Epoch.** What a robot says counts only once it has repeated this mediator's epoch: before that its levels may be about
//!   another start of the mediator.
//! * **Silence.** A robot that was not heard for a while is silent: it is granted nothing, and keeps what it has.

mod awaited;
mod factsheet;
mod numbers;
mod refusing;
mod session;
mod table;

pub(crate) use awaited::Heard;
pub use factsheet::Factsheet;
pub(crate) use table::Sessions;

#[cfg(test)]
mod tests;
