//! Protocol 1: a robot acquires and releases an area.

use std::fmt;
use std::sync::Arc;

use coordination::acquire_release::{AcquireRelease, By, Resource};
use coordination::protocol::{FlagId, Position, Protocol};

use super::model::flag;
use super::names::{ENTERED, GRANTED, MEDIATOR, RELEASED, REQUEST, RETURNED, ROBOT};

/// Protocol 1: request, granted, then entered and released, or returned.
#[must_use]
pub fn access() -> Protocol {
    Protocol::clone(resource().protocol())
}

/// An area as a resource: the robot uses what the mediator owns.
fn resource() -> Resource {
    let mut area = AcquireRelease::new("access", ROBOT, MEDIATOR);
    area.keeper(By::Owner)
        .acquire(REQUEST, GRANTED)
        .using(ENTERED, By::User)
        .release(RELEASED)
        .give_back(RETURNED);
    area.compile()
        .expect("the contract's own arrays are consistent; a test compiles them")
}

/// [`access`] with its flags and positions looked up, for either side. Clones share the protocol.
#[derive(Clone)]
pub struct AccessProtocol {
    /// For the two sides.
    pub protocol: Arc<Protocol>,
    /// What its positions mean.
    pub resource: Resource,
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
    /// Asked for and not yet granted.
    pub requested_at: Position,
    /// Granted and not yet entered.
    pub granted_at: Position,
    /// Entered and not yet released.
    pub entered_at: Position,
}

/// By its name: it never changes, and what has one is printed and compared often.
impl fmt::Debug for AccessProtocol {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("AccessProtocol")
    }
}

impl AccessProtocol {
    /// The protocol of every robot and area.
    #[must_use]
    #[expect(clippy::new_without_default, reason = "there is nothing to choose")]
    pub fn new() -> Self {
        let resource = resource();
        let protocol = Arc::clone(resource.protocol());
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
            requested_at: at_end_of(&[request]),
            granted_at: at_end_of(&[request, granted]),
            entered_at: at_end_of(&[request, granted, entered]),
            protocol,
            resource,
        }
    }

    /// At this position the robot has the area: from `granted` until `released` or `returned`.
    #[must_use]
    pub fn is_held(&self, at: Position) -> bool {
        self.resource.is_held(at)
    }
}
