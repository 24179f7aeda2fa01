//! The compiled pattern: a protocol, and what its positions mean.

use alloc::sync::Arc;

use crate::protocol::{FlagId, Party, Position, Protocol};

/// What a position of the protocol means for the resource.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Phase {
    /// Nobody asks.
    Free,
    /// The user has asked, and the owner has not answered.
    Wanted,
    /// The user has it.
    Held,
    /// The user has released it, and the owner has not confirmed that.
    Releasing,
    /// The run is over: released, given back or refused. Reading the last flag makes the resource free.
    Over,
}

/// A protocol by which a resource is acquired and released; see [the module](super). Clones share the protocol.
#[derive(Clone, Debug)]
pub struct Resource {
    protocol: Arc<Protocol>,
    user: Party,
    /// By position.
    phases: Arc<[Phase]>,
}

impl Resource {
    pub(super) fn new(
        protocol: Arc<Protocol>,
        user: Party,
        granted: FlagId,
        release: FlagId,
    ) -> Self {
        let phase = |at: Position| {
            if at == Position::START {
                return Phase::Free;
            }
            if protocol.is_end(at) {
                return Phase::Over;
            }
            let has = |wanted: FlagId| protocol.set_flags(at).any(|(flag, _)| flag == wanted);
            if has(release) {
                Phase::Releasing
            } else if has(granted) {
                Phase::Held
            } else {
                Phase::Wanted
            }
        };
        Self {
            phases: protocol.positions().map(phase).collect(),
            protocol,
            user,
        }
    }

    /// For the two sides.
    #[must_use]
    pub fn protocol(&self) -> &Arc<Protocol> {
        &self.protocol
    }

    /// The party that acquires; the other one owns.
    #[must_use]
    pub fn user(&self) -> Party {
        self.user
    }

    /// What a position means; [`Phase::Over`] for one of another protocol.
    #[must_use]
    pub fn phase(&self, at: Position) -> Phase {
        self.phases.get(at.index()).copied().unwrap_or(Phase::Over)
    }

    /// At this position the user has the resource: from the grant until it releases it or gives it back.
    #[must_use]
    pub fn is_held(&self, at: Position) -> bool {
        self.phase(at) == Phase::Held
    }
}
