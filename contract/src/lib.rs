//! What robots and mediator say to each other: messages, protocols, key expressions, versions.
//!
//! The public contract is `proto/fleet.proto` with `PROTOCOL.md`; this crate is its Rust side: the
//! keys of [`keys`], the messages of [`wire`], the robot's side of its protocols in [`client`], and with feature `network` the
//! session.

pub mod client;
pub mod keys;
pub mod level;
#[cfg(feature = "network")]
pub mod network;
pub mod protocols;
pub mod timing;
mod version;

/// The messages, generated from `proto/fleet.proto`.
#[allow(missing_docs, clippy::all)]
pub mod wire {
    include!(concat!(env!("OUT_DIR"), "/kelo.fleet.v1.rs"));
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
