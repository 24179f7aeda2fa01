//! Protocol 1: a robot acquires and releases an area.

use std::sync::Arc;

use coordination::protocol::{FlagId, Position, Protocol};

use super::model::{self, compiled, flag};
use super::names::{ENTERED, GRANTED, MEDIATOR, RELEASED, REQUEST, RETURNED, ROBOT};

/// Protocol 1: request, granted, then entered and released, or returned.
#[must_use]
pub fn access() -> Protocol {
    let mut model = model::model("access");
    model
        .array("ask", &[(REQUEST, ROBOT), (GRANTED, MEDIATOR)])
        .array("pass", &[(ENTERED, ROBOT), (RELEASED, ROBOT)])
        .array("return", &[(RETURNED, ROBOT)])
        .follow("ask", "pass")
        .follow("ask", "return");
    compiled(&model)
}

/// [`access`] with its flags and positions looked up, for either side. Clones share the protocol.
#[derive(Clone, Debug)]
pub struct AccessProtocol {
    /// For the two sides.
    pub protocol: Arc<Protocol>,
    /// [`REQUEST`]
    pub request: FlagId,
    /// [`GRANTED`]
    pub granted: FlagId,
    /// [`ENTERED`]
    pub entered: FlagId,
    /// [`RELEASED`]
    pub released: FlagId,
    /// [`RETURNED`]
    pub returned: FlagId,
    /// Granted and not yet entered.
    pub granted_at: Position,
    /// Entered and not yet released.
    pub entered_at: Position,
}

impl AccessProtocol {
    /// The protocol of every robot and area.
    #[must_use]
    #[expect(clippy::new_without_default, reason = "there is nothing to choose")]
    pub fn new() -> Self {
        let protocol = access();
        let at_end_of = |flags: &[FlagId]| {
            { flags.iter() }
                .try_fold(Position::START, |at, &flag| protocol.after(at, flag))
                .expect("the access protocol has its order; a test looks it up")
        };
        let flag = |name| flag(&protocol, name);
        let (request, granted, entered) = (flag(REQUEST), flag(GRANTED), flag(ENTERED));
        Self {
            request,
            granted,
            entered,
            released: flag(RELEASED),
            returned: flag(RETURNED),
            granted_at: at_end_of(&[request, granted]),
            entered_at: at_end_of(&[request, granted, entered]),
            protocol: Arc::new(protocol),
        }
    }

    /// At this position the robot has the area: from `granted` until `released` or `returned`.
    #[must_use]
    pub fn is_held(&self, at: Position) -> bool {
        at == self.granted_at || at == self.entered_at
    }
}
