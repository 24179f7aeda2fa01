//! Taking a grant back, with the robot's consent.

use std::fmt;
use std::sync::Arc;

use coordination::acquire_release::Revocation;
use coordination::protocol::{FlagId, Protocol};

use super::model::model;
use super::names::{KEPT, MEDIATOR, REVOKE, ROBOT, YIELDED};

/// Taking a grant back: revoke, then yielded or kept.
#[must_use]
pub fn revocation() -> Protocol {
    Protocol::clone(&compiled().protocol)
}

fn compiled() -> Revocation {
    let flags = [REVOKE, YIELDED, KEPT];
    Revocation::compile(model("revocation"), ROBOT, MEDIATOR, flags)
        .expect("the contract's own arrays are consistent; a test compiles them")
}

/// [`revocation`] with its flags looked up, for either side. Clones share the protocol.
#[derive(Clone)]
pub struct RevocationProtocol {
    /// For the two sides.
    pub protocol: Arc<Protocol>,
    /// [`REVOKE`]
    pub revoke: FlagId,
    /// [`YIELDED`]
    pub yielded: FlagId,
    /// [`KEPT`]
    pub kept: FlagId,
}

/// By its name: it never changes, and what has one is printed and compared often.
impl fmt::Debug for RevocationProtocol {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("RevocationProtocol")
    }
}

impl RevocationProtocol {
    /// The protocol of every robot and area.
    #[must_use]
    #[expect(clippy::new_without_default, reason = "there is nothing to choose")]
    pub fn new() -> Self {
        let Revocation {
            protocol,
            revoke,
            yielded,
            kept,
        } = compiled();
        Self {
            protocol,
            revoke,
            yielded,
            kept,
        }
    }
}
