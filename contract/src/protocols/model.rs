//! What all protocols between robot and mediator have in common.

use std::sync::Arc;

use coordination::protocol::{FlagId, Party, Protocol, ProtocolModel, Replica};

use super::names::{MEDIATOR, ROBOT};
use crate::level::PROTOCOL_ID;

/// An empty protocol between robot and mediator, which the mediator keeps.
pub(super) fn model(name: &str) -> ProtocolModel {
    let mut model = ProtocolModel::new(name, ROBOT, MEDIATOR);
    model.keeper(MEDIATOR);
    model
}

/// A flag of a protocol that this crate itself declares.
pub(super) fn flag(protocol: &Protocol, name: &str) -> FlagId {
    protocol
        .flag(name)
        .expect("the contract's own arrays have their flags; a test looks them up")
}

/// One party's side of a protocol between robot and mediator, before the first run.
#[must_use]
pub fn begin(protocol: &Arc<Protocol>, party: Party) -> Replica {
    Replica::new(protocol, PROTOCOL_ID, party, 0)
}
