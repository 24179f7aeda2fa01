//! What robots and mediator say to each other: messages, protocols, key expressions, versions.
//!
//! The public contract is `proto/fleet.proto` with `PROTOCOL.md`; this crate is its Rust side:
//!
//! * [`wire`]: the messages; [`keys`]: the keys under which they go; [`level`]: levels in messages;
//! * [`floor`]: the areas that both sides must know alike, and their hash;
//! * [`protocols`]: the protocols as flag arrays, with their flags looked up; [`timing`]: periods and timeouts of both sides;
//! * [`client`]: the robot's side of all protocols, pure;
//! * `network` (a feature): the zenoh session;
//! * [`private`]: folders, files and sockets that are nobody else's, for the ends of all this on either machine; [`logging`]: their log.
//!
//! Everything allocates; not for real-time threads. Units are those of the message's field names, poses are in the `map` frame.
//!
//! # Example
//! A robot is registered, asks for an area, and is granted it:
//! ```
//! use contract::VERSION;
//! use contract::client::{Client, Received, Situation};
//! use contract::floor::Floor;
//! use contract::timing::{LEASE_NS, SILENT_AFTER_NS};
//! use contract::wire::{AccessGrant, Level, MediatorReport};
//!
//! let mut robot = Client::new("amr-1", "hall", 7);
//! let mut answer = MediatorReport {
//!     version: Some(VERSION.into()),
//!     instance: 60,
//!     journal: 70,
//!     mediator_epoch: 1,
//!     sequence: 1,
//!     robot_id: "amr-1".into(),
//!     boot_epoch: 7,
//!     session: 1,
//!     floor_hash: Floor::default().hash(),
//!     ..MediatorReport::default()
//! };
//! assert_eq!(robot.receive(&answer, 0), Received::Registered);
//!
//! let wants = Situation { located: true, wanted: vec!["gate".into()], ..Situation::default() };
//! assert!(robot.step(wants, 0, SILENT_AFTER_NS), "there is news: `request` is set");
//! let report = robot.report();
//! assert_eq!(report.access[0].level.map(|level| level.progress), Some(1));
//!
//! answer.sequence = 2;
//! answer.robot_sequence = report.sequence;
//! answer.access = vec![AccessGrant {
//!     area: "gate".into(),
//!     level: Some(Level { progress: 2, ..Level::default() }),
//!     fence: 1,
//!     ..AccessGrant::default()
//! }];
//! robot.receive(&answer, 0);
//! assert!(robot.holds("gate") && robot.may_be_in("gate", LEASE_NS));
//! assert!(!robot.may_be_in("gate", LEASE_NS + 1), "it has not entered, and heard nothing more");
//! ```

pub mod client;
pub mod draw;
pub mod floor;
mod instruction;
pub mod keys;
pub mod level;
pub mod logging;
pub mod mention;
#[cfg(feature = "network")]
pub mod network;
#[cfg(test)]
mod page;
pub mod private;
pub mod protocols;
pub mod timing;
mod version;

/// The messages, generated from `proto/fleet.proto`.
#[allow(missing_docs, clippy::all)]
pub mod wire {
    include!(concat!(env!("OUT_DIR"), "/kelo.fleet.v2.rs"));
}

pub use prost::Message;
pub use version::{VERSION, Version, VersionMismatch};

/// Decodes a message that came from the network.
///
/// # Errors
/// [`prost::DecodeError`] when the bytes are not such a message.
pub fn decode<M: Message + Default>(bytes: &[u8]) -> Result<M, prost::DecodeError> {
    M::decode(bytes)
}

#[cfg(test)]
mod tests {
    use super::wire::{Pose, RobotState};
    use super::*;

    #[test]
    fn a_state_survives_the_wire() {
        let state = RobotState {
            robot_id: "amr-1".into(),
            boot_epoch: 7,
            sequence: 3,
            pose: Some(Pose {
                x_m: 1.5,
                ..Pose::default()
            }),
            ..RobotState::default()
        };
        let back: RobotState = decode(&state.encode_to_vec()).expect("decodes");
        assert_eq!(back, state);
    }

    #[test]
    fn foreign_bytes_are_an_error() {
        assert!(decode::<RobotState>(&[0xff; 7]).is_err());
    }
}
