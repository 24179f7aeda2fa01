//! Communication: publishes the robot's state on the fleet's network, and on a managed site talks with the mediator, as
//! `contract` defines.
//!
//! Its event loop runs as soon as the mediator or navigation has news, and in any case with its period.
//!
//! The only activity with an asynchronous side: its thread drives a tokio runtime with one worker, as zenoh wants it.

mod activity;
mod credentials;
mod hearing;
mod membership;
mod network;
mod settings;
mod state;

pub use activity::{Communication, PERIOD};
pub use credentials::{Attention, read_identity};
pub use membership::MembershipSetup;
pub use network::{Inbox, OpenSession, Session, zenoh_session};
pub use settings::Settings;
