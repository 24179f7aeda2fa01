//! Who speaks for a robot: identity, registration, restarts, silence.
//!
//! * **Identity.** The site lists its robots; nobody else gets anything but a refusal.
//! * **Boot and session.** One process at a time speaks for a robot. Another one that reports is only a *candidate*: the present
//!   one goes on speaking until the candidate has repeated the session number that it was offered. So a late message of a dead
//!   process takes nothing from a living one.
//! * **Epoch.** What a robot says counts only once it has repeated this mediator's epoch: before that its levels may be about
//!   another start of the mediator.
//! * **Silence.** A robot that was not heard for a while is silent: it is granted nothing, and keeps what it has.

mod session;
mod table;

pub(crate) use table::Sessions;

#[cfg(test)]
mod tests;
