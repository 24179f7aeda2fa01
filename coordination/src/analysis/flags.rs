//! What the sources and sinks of a net hang on: events, flags of protocols, aborts.

use super::refusal::Reason;
use crate::listed::listed;
use crate::petri::{Binding, Place, PlaceKind};
use crate::protocol::{ABORTED, FlagId, Party, Protocol};

/// A protocol under the name that the net's bindings use, and the party that the net is.
#[derive(Clone, Copy, Debug)]
pub(crate) struct NamedProtocol<'a> {
    pub(crate) name: &'a str,
    pub(crate) protocol: &'a Protocol,
    pub(crate) net_party: Party,
}

/// What a place is bound to; protocols are numbers in their list.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Outside {
    Nothing,
    Event,
    Flag(u16, FlagId),
    Abort(u16),
}

/// Every name stands once.
pub(crate) fn check_names(protocols: &[NamedProtocol<'_>]) -> Result<(), Box<Reason>> {
    if protocols.len() > usize::from(u16::MAX) {
        return Err(Box::new(Reason::TooLarge {
            what: "protocols",
            limit: u16::MAX.into(),
            proved: String::new(),
        }));
    }
    let mut seen = std::collections::HashSet::new();
    match protocols.iter().find(|own| !seen.insert(own.name)) {
        None => Ok(()),
        Some(twice) => Err(Box::new(Reason::TwoProtocols {
            protocol: twice.name.to_owned(),
        })),
    }
}

/// What a place hangs on: a source on flags of the other party, a sink on those of the net's own.
pub(crate) fn resolve(
    protocols: &[NamedProtocol<'_>],
    place: &Place<'_>,
) -> Result<Outside, Box<Reason>> {
    let (name, flag) = match place.binding {
        None => return Ok(Outside::Nothing),
        Some(Binding::Event(_)) => return Ok(Outside::Event),
        Some(Binding::Flag { protocol, flag }) => (protocol, flag),
    };
    let user = || place.name.to_owned();
    let mut numbered = protocols.iter().zip(0..);
    let Some((own, number)) = numbered.find(|(own, _)| own.name == name) else {
        return Err(Box::new(Reason::UnknownProtocol {
            place: user(),
            protocol: name.clone(),
            known: listed(protocols.iter().map(|own| own.name)),
        }));
    };
    let protocol = own.protocol;
    let (expected, kind) = match place.kind {
        PlaceKind::Sink => (own.net_party, "sink"),
        _ => (own.net_party.other(), "source"),
    };
    let id = protocol.flag(flag);
    let owner = match id {
        Some(id) => protocol.owner(id),
        None if flag == ABORTED => protocol.keeper(),
        None => None,
    };
    let Some(owner) = owner else {
        return Err(Box::new(Reason::UnknownFlag {
            place: user(),
            protocol: name.clone(),
            flag: flag.clone(),
            known: listed(protocol.flags().map(|(_, name, _)| name)),
        }));
    };
    if owner != expected || (id.is_none() && place.kind == PlaceKind::Sink) {
        return Err(Box::new(Reason::WrongOwner {
            kind,
            place: user(),
            protocol: name.clone(),
            flag: flag.clone(),
            owner: protocol.party_name(owner).to_owned(),
            expected: protocol.party_name(expected).to_owned(),
        }));
    }
    Ok(id.map_or(Outside::Abort(number), |id| Outside::Flag(number, id)))
}
