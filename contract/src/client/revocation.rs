//! Revocation of one area's grant, from the robot's side.

use std::sync::Arc;

use coordination::protocol::{FlagId, MergeError, Party, Position, Protocol, Replica, Side};

use crate::level::{self, PROTOCOL_ID};
use crate::protocols::{self, KEPT, ROBOT, YIELDED};
use crate::wire::Access;

#[derive(Clone, Debug)]
pub(super) struct RevocationProtocol {
    protocol: Arc<Protocol>,
    robot: Party,
    yielded: FlagId,
    kept: FlagId,
}

#[derive(Clone, Debug)]
pub(super) struct Revocation {
    replica: Replica,
    /// Of the grant that is asked back.
    pub(super) fence: u64,
}

impl RevocationProtocol {
    pub(super) fn new() -> Self {
        let protocol = protocols::revocation();
        let flag = |name| {
            protocol
                .flag(name)
                .expect("the revocation protocol has its flags")
        };
        Self {
            robot: protocol
                .party(ROBOT)
                .expect("the revocation protocol has its parties"),
            yielded: flag(YIELDED),
            kept: flag(KEPT),
            protocol: Arc::new(protocol),
        }
    }

    pub(super) fn begin(&self) -> Revocation {
        Revocation {
            replica: Replica::new(&self.protocol, PROTOCOL_ID, self.robot, 0),
            fence: 0,
        }
    }

    pub(super) fn resume(&self, access: &Access) -> Option<Revocation> {
        let level = level::decode(access.level.as_ref()).ok()?;
        Some(Revocation {
            replica: Replica::resume(&self.protocol, self.robot, level).ok()?,
            fence: access.fence,
        })
    }

    /// Answers what is asked; `false` when nothing was.
    pub(super) fn answer(&self, revocation: &mut Revocation, yields: bool) -> bool {
        let flag = if yields { self.yielded } else { self.kept };
        revocation.replica.set(flag).is_ok()
    }
}

impl Revocation {
    /// Takes in what the mediator says; `false` when it makes no sense.
    pub(super) fn learn(&mut self, access: &Access) -> bool {
        let Ok(level) = level::decode(access.level.as_ref()) else {
            return false;
        };
        let merged: Result<_, MergeError> = self.replica.merge(level);
        while self.replica.poll().is_some() {
            self.fence = access.fence;
        }
        merged.is_ok()
    }

    /// The grant is asked back, and there is no answer yet.
    pub(super) fn is_asked(&self) -> bool {
        let at = self.replica.position();
        at != Position::START && !self.replica.protocol().is_end(at)
    }

    /// It was ever used.
    pub(super) fn is_known(&self) -> bool {
        self.replica.run() > 0 || self.replica.position() != Position::START
    }

    pub(super) fn report(&self, area: &str) -> Access {
        Access {
            area: area.to_owned(),
            level: Some(level::encode(self.replica.level())),
            fence: self.fence,
        }
    }
}
