//! Protocol 1 of one area, from the robot's side.

use std::sync::Arc;

use coordination::protocol::{FlagId, Party, Position, Protocol, Replica};

use crate::level::PROTOCOL_ID;
use crate::protocols::{self, ENTERED, GRANTED, RELEASED, REQUEST, RETURNED, ROBOT};

#[derive(Clone, Debug)]
pub(super) struct AccessProtocol {
    pub(super) protocol: Arc<Protocol>,
    pub(super) robot: Party,
    pub(super) request: FlagId,
    pub(super) granted: FlagId,
    pub(super) entered: FlagId,
    pub(super) released: FlagId,
    pub(super) returned: FlagId,
    pub(super) granted_at: Position,
    pub(super) entered_at: Position,
}

#[derive(Clone, Debug)]
pub(super) struct Run {
    pub(super) replica: Replica,
    pub(super) fence: u64,
    pub(super) waits_for: String,
    /// Taken over from the mediator after a restart, and not yet confirmed by where the robot stands.
    pub(super) inherited: bool,
}

impl AccessProtocol {
    pub(super) fn new() -> Self {
        let protocol = protocols::access();
        let flag = |name| {
            protocol
                .flag(name)
                .expect("the access protocol has its flags")
        };
        let after = |at, flag| {
            protocol
                .after(at, flag)
                .expect("the access protocol has its order")
        };
        let (request, granted, entered) = (flag(REQUEST), flag(GRANTED), flag(ENTERED));
        let granted_at = after(after(Position::START, request), granted);
        Self {
            robot: protocol
                .party(ROBOT)
                .expect("the access protocol has its parties"),
            request,
            granted,
            entered,
            released: flag(RELEASED),
            returned: flag(RETURNED),
            granted_at,
            entered_at: after(granted_at, entered),
            protocol: Arc::new(protocol),
        }
    }

    pub(super) fn begin(&self) -> Run {
        Run {
            replica: Replica::new(&self.protocol, PROTOCOL_ID, self.robot, 0),
            fence: 0,
            waits_for: String::new(),
            inherited: false,
        }
    }

    pub(super) fn is_held(&self, run: &Run) -> bool {
        let at = run.replica.position();
        at == self.granted_at || at == self.entered_at
    }
}
