//! How a net's sources and sinks hang on the flags of protocol sides.

use std::sync::Arc;

use super::error::BindError;
use crate::analysis::Reason;
use crate::analysis::flags::{NamedProtocol, Outside, check_names, resolve};
use crate::event::EventId;
use crate::petri::{Executor, Net, PlaceId, PlaceKind};
use crate::protocol::{Change, FlagId, Party, Position, Protocol, SetError, Side};

/// The most events of one flag that wait for a source.
pub(super) const MAX_HELD: u8 = u8::MAX;

/// A sink's flag: in which protocol, and which.
#[derive(Clone, Copy, Debug)]
pub(super) struct Outgoing {
    pub(super) port: u16,
    pub(super) flag: FlagId,
}

/// One protocol and what the net is bound to there.
#[derive(Clone, Debug)]
pub(super) struct Port {
    pub(super) name: Box<str>,
    /// What its side must be one of, whoever exchanges sides.
    pub(super) protocol: Arc<Protocol>,
    party: Party,
    /// Up to where the net has read and set its flags, when it last gave the side out of its hands.
    at: Position,
    /// By flag of the other party: the event of the sources bound to it.
    pub(super) incoming: Box<[Option<EventId>]>,
    pub(super) aborted: Option<EventId>,
    /// Bound to the abort.
    abort_sources: Vec<PlaceId>,
    /// Bound to flags of the other party, by flag.
    pub(super) sources: Vec<(FlagId, PlaceId)>,
    /// Bound to flags of this party.
    pub(super) sinks: Vec<(FlagId, PlaceId)>,
    /// The most flags that are read at a time.
    pub(super) longest_run: u16,
    pub(super) aborts: u64,
    pub(super) refusal: Option<(FlagId, SetError)>,
}

/// All ports of a net.
#[derive(Clone, Debug)]
pub(super) struct Wiring {
    /// In the order of the sides.
    pub(super) ports: Box<[Port]>,
    /// By event, as far as sinks have flags.
    pub(super) outgoing: Box<[Option<Outgoing>]>,
    /// By event: whether it stands for a flag, or for an abort.
    pub(super) flags: Box<[bool]>,
}

impl Wiring {
    /// Finds the flag of each source and sink of `net`, or all that does not fit.
    pub(super) fn new<S: Side>(
        net: &Net,
        names: Vec<Box<str>>,
        sides: &[S],
    ) -> Result<Self, Vec<BindError>> {
        let known: Vec<NamedProtocol<'_>> = { names.iter().zip(sides) }
            .map(|(name, side)| NamedProtocol {
                name,
                protocol: side.protocol(),
                net_party: side.party(),
            })
            .collect();
        let twice = check_names(&known).err();
        let mut errors: Vec<BindError> = twice.map(BindError::Place).into_iter().collect();
        let mut ports: Box<[Port]> = { names.iter().zip(sides) }
            .map(|(name, side)| Port::new(name.clone(), side))
            .collect();
        let (mut outgoing, mut flags) = (Vec::new(), Vec::new());
        let model = net.model();
        for (place, found) in net.places().zip(model.places()) {
            let (number, flag) = match resolve(&known, &found) {
                Ok(Outside::Nothing | Outside::Event) => continue,
                Ok(Outside::Flag(number, flag)) => (number, Some(flag)),
                Ok(Outside::Abort(number)) => (number, None),
                Err(reason) => {
                    errors.push(reason.into());
                    continue;
                }
            };
            let port = &mut ports[usize::from(number)];
            let is_sink = found.kind == PlaceKind::Sink;
            let events = if is_sink { net.sinks() } else { net.sources() };
            let Ok(index) = events.binary_search_by_key(&place, |&(place, _)| place) else {
                continue;
            };
            let event = events[index].1;
            if flags.len() <= event.index() {
                flags.resize(event.index() + 1, false);
            }
            flags[event.index()] = true;
            match flag {
                Some(flag) if is_sink => {
                    if outgoing.len() <= event.index() {
                        outgoing.resize(event.index() + 1, None);
                    }
                    port.sinks.push((flag, place));
                    outgoing[event.index()] = Some(Outgoing { port: number, flag });
                }
                Some(flag) => {
                    let side = &sides[usize::from(number)];
                    errors.extend(port.add_source(side, place, event, flag));
                }
                None => {
                    port.aborted = Some(event);
                    port.abort_sources.push(place);
                }
            }
        }
        if !errors.is_empty() {
            return Err(errors);
        }
        Ok(Self {
            ports,
            outgoing: outgoing.into(),
            flags: flags.into(),
        })
    }

    /// Whether an event stands for a flag, or for an abort.
    pub(super) fn is_flag(&self, event: EventId) -> bool {
        self.flags
            .get(event.index())
            .is_some_and(|&is_flag| is_flag)
    }
}

impl Port {
    fn new<S: Side>(name: Box<str>, side: &S) -> Self {
        Self {
            name,
            protocol: Arc::new(side.protocol().clone()),
            party: side.party(),
            at: side.read_to(),
            incoming: vec![None; side.protocol().flags().count()].into(),
            aborted: None,
            abort_sources: Vec::new(),
            sources: Vec::new(),
            sinks: Vec::new(),
            longest_run: longest_run(side.protocol()),
            aborts: 0,
            refusal: None,
        }
    }

    /// Lets `flag`, whose event is `event`, fill `place` too.
    fn add_source<S: Side>(
        &mut self,
        side: &S,
        place: PlaceId,
        event: EventId,
        flag: FlagId,
    ) -> Option<BindError> {
        let protocol = side.protocol();
        let abortable = protocol.keeper() == Some(side.party().other());
        let first = self.incoming[flag.index()].replace(event).is_none();
        self.sources.push((flag, place));
        let several = || {
            Box::new(Reason::SeveralSources {
                protocol: self.name.to_string(),
                flag: protocol.flag_name(flag).to_owned(),
            })
        };
        (abortable && !first).then(|| several().into())
    }

    /// The side goes to somebody else for a while.
    pub(super) fn lend<S: Side>(&mut self, side: &S) {
        self.at = side.read_to();
    }

    /// Whether a side has come back as one of the same protocol and party, that neither read nor set a flag. Takes
    /// constant time if it shares the protocol, which one of the proof's does.
    pub(super) fn fits<S: Side>(&self, side: &S) -> bool {
        self.is_of(side) && side.read_to() == self.at
    }

    /// Whether a side is one of the same protocol and party.
    pub(super) fn is_of<S: Side>(&self, side: &S) -> bool {
        let protocol = side.protocol();
        side.party() == self.party
            && (core::ptr::eq(&*self.protocol, protocol) || *self.protocol == *protocol)
    }

    /// The sources of `flag`.
    pub(super) fn sources_of(&self, flag: FlagId) -> impl Iterator<Item = PlaceId> {
        let sources = self.sources.iter().filter(move |&&(of, _)| of == flag);
        sources.map(|&(_, place)| place)
    }

    /// Whether there is something to read that may be read now.
    pub(super) fn can_read<S: Side>(&self, side: &S, executor: &Executor) -> bool {
        let is_unread = |&place: &PlaceId| executor.is_marked(place) || executor.waiting(place) > 0;
        if self.abort_sources.iter().any(is_unread) {
            return false;
        }
        match side.peek() {
            None => false,
            Some(Change::Aborted) => true,
            Some(Change::Flag(flag)) => self
                .sources_of(flag)
                .all(|place| executor.waiting(place) < MAX_HELD.into()),
        }
    }
}

/// The most flags that one run sets.
fn longest_run(protocol: &Protocol) -> u16 {
    let depths = protocol.positions().map(|at| protocol.progress(at));
    depths.max().unwrap_or(0)
}
