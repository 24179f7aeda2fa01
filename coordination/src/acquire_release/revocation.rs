//! An owner asks for a granted resource back.

use alloc::sync::Arc;

use crate::protocol::{FlagId, ModelError, Protocol, ProtocolModel};

/// The protocol beside the one of the resource by which its owner asks for it back: the user yields or keeps it. Who yields gives
/// it back in the other protocol. Clones share the protocol.
#[derive(Clone, Debug)]
pub struct Revocation {
    /// For the two sides; the parties are in the order of the model that was given.
    pub protocol: Arc<Protocol>,
    /// The owner's flag that asks.
    pub revoke: FlagId,
    /// The user's flag that gives it back.
    pub yielded: FlagId,
    /// The user's flag that keeps it.
    pub kept: FlagId,
}

impl Revocation {
    /// Declares the three flags in `model`, which has parties and no arrays, and compiles it. Not for real-time threads.
    ///
    /// # Errors
    /// If names are empty or the same, or a party is unknown.
    pub fn compile(
        mut model: ProtocolModel,
        user: &str,
        owner: &str,
        [revoke, yielded, kept]: [&str; 3],
    ) -> Result<Self, ModelError> {
        model
            .array("ask", &[(revoke, owner)])
            .array("yield", &[(yielded, user)])
            .array("keep", &[(kept, user)])
            .follow("ask", "yield")
            .follow("ask", "keep");
        let protocol = model.compile()?;
        let flag = |name| protocol.flag(name).expect("each is in an array");
        Ok(Self {
            revoke: flag(revoke),
            yielded: flag(yielded),
            kept: flag(kept),
            protocol: Arc::new(protocol),
        })
    }
}
