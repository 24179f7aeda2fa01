//! Taking a grant back, with the robot's consent.

use std::sync::Arc;

use coordination::protocol::{FlagId, Protocol};

use super::model::{self, compiled, flag};
use super::names::{KEPT, MEDIATOR, REVOKE, ROBOT, YIELDED};

/// Taking a grant back: revoke, then yielded or kept.
#[must_use]
pub fn revocation() -> Protocol {
    let mut model = model::model("revocation");
    model
        .array("ask", &[(REVOKE, MEDIATOR)])
        .array("yield", &[(YIELDED, ROBOT)])
        .array("keep", &[(KEPT, ROBOT)])
        .follow("ask", "yield")
        .follow("ask", "keep");
    compiled(&model)
}

/// [`revocation`] with its flags looked up, for either side. Clones share the protocol.
#[derive(Clone, Debug)]
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

impl RevocationProtocol {
    /// The protocol of every robot and area.
    #[must_use]
    #[expect(clippy::new_without_default, reason = "there is nothing to choose")]
    pub fn new() -> Self {
        let protocol = revocation();
        Self {
            revoke: flag(&protocol, REVOKE),
            yielded: flag(&protocol, YIELDED),
            kept: flag(&protocol, KEPT),
            protocol: Arc::new(protocol),
        }
    }
}
