//! The compiled pattern: a protocol, and what its positions mean.

use alloc::sync::Arc;
use alloc::vec::Vec;

use thiserror::Error;

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

/// A protocol has a path by which nothing is acquired and released as was said.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
#[error("a path of the protocol, which ends at {end:?}, acquires and releases otherwise")]
pub struct OtherPath {
    /// The end of that path.
    pub end: Position,
}

impl Resource {
    /// A protocol that was declared in another way, as one with branches is, and acquires a resource for `user` all the same: each
    /// path begins with the flags of `acquire`, of which the user sets the first and the owner the second, and ends with those of
    /// `release`, again the user's and the owner's.
    ///
    /// # Errors
    /// [`OtherPath`] for the first path that does not.
    pub fn of(
        protocol: &Arc<Protocol>,
        user: Party,
        acquire: [&str; 2],
        release: [&str; 2],
    ) -> Result<Self, OtherPath> {
        let flags = |names: [&str; 2]| names.map(|name| protocol.flag(name));
        let (acquire, release) = (flags(acquire), flags(release));
        let set_by = |flag: FlagId, of_user: bool| (protocol.owner(flag) == Some(user)) == of_user;
        let is = |found: &[FlagId], expected: [Option<FlagId>; 2]| {
            { found.iter().map(|&flag| Some(flag)) }.eq(expected)
                && set_by(found[0], true)
                && set_by(found[1], false)
        };
        for end in protocol.positions().filter(|&at| protocol.is_end(at)) {
            let path: Vec<FlagId> = protocol.set_flags(end).map(|(flag, _)| flag).collect();
            let fits =
                path.len() >= 4 && is(&path[..2], acquire) && is(&path[path.len() - 2..], release);
            if !fits {
                return Err(OtherPath { end });
            }
        }
        let known = |flag: Option<FlagId>| flag.expect("each path has it");
        let [granted, release] = [known(acquire[1]), known(release[0])];
        Ok(Self::new(Arc::clone(protocol), user, granted, release))
    }

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
