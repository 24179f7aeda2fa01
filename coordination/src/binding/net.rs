//! The mediator's half: a net and one protocol side per robot.

use super::error::{BindError, Named, Role, duplicates, find_flag, longest_run};
use crate::event::EventId;
use crate::petri::{Binding, Budget, Evaluation, Executor, Net, OfferError, PlaceId, PlaceKind};
use crate::protocol::{AbortError, Change, FlagId, SetError, Side};

/// What one call of [`NetBinding::step`] did.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Progress {
    /// How many flags of the other parties were read.
    pub read: u32,
    /// What the net did.
    pub evaluation: Evaluation,
    /// How many flags of this party were set.
    pub set: u32,
    /// There is more to do, without any news: call again.
    pub remaining: bool,
}

/// A sink's flag: in which protocol, and which.
#[derive(Clone, Copy, Debug)]
struct Outgoing {
    port: u16,
    flag: FlagId,
}

/// A flag of the other party.
#[derive(Clone, Copy, Debug, Default)]
struct Incoming {
    /// The event of the sources bound to it.
    event: Option<EventId>,
    /// Read, and not offered to the net yet, because its sources are full.
    held: u8,
}

const MAX_HELD: u8 = u8::MAX;

/// One protocol and what the net is bound to there.
#[derive(Debug)]
struct Port<S> {
    name: Box<str>,
    side: S,
    /// By flag.
    incoming: Box<[Incoming]>,
    aborted: Option<EventId>,
    /// Bound to the abort.
    abort_sources: Vec<PlaceId>,
    /// Bound to flags of the other party, by flag.
    sources: Vec<(FlagId, PlaceId)>,
    /// The most flags that are read at a time.
    longest_run: u16,
    aborts: u64,
    refusal: Option<(FlagId, SetError)>,
}

/// A running net whose sources and sinks are flags of protocols; see [the module](super).
#[derive(Debug)]
pub struct NetBinding<S> {
    executor: Executor,
    ports: Box<[Port<S>]>,
    /// By event, as far as sinks have flags.
    outgoing: Box<[Option<Outgoing>]>,
    /// By event: whether it stands for a flag, or for an abort.
    flags: Box<[bool]>,
    refused: u64,
}

impl<S: Side> NetBinding<S> {
    /// The most events of one flag that wait for its source.
    pub const MAX_HELD: u8 = MAX_HELD;

    /// Binds `net`, in its initial marking, to protocols under the names that the net's bindings
    /// use. Returns all that does not fit.
    pub fn new<N: Into<Box<str>>>(
        net: &Net,
        sides: impl IntoIterator<Item = (N, S)>,
    ) -> Result<Self, Vec<BindError>> {
        let mut ports: Box<[Port<S>]> = sides
            .into_iter()
            .map(|(name, side)| Port::new(name.into(), side))
            .collect();
        let mut errors = duplicates(ports.iter().map(|port| &*port.name));
        let (mut outgoing, mut flags) = (Vec::new(), Vec::new());
        let model = net.model();
        for (place, found) in net.places().zip(model.places()) {
            let Some(Binding::Flag { protocol, flag }) = found.binding else {
                continue;
            };
            let user = || format!("place `{}`", found.name);
            let Some(number) = ports.iter().position(|port| *port.name == **protocol) else {
                let known: Vec<_> = ports.iter().map(|port| &*port.name).collect();
                errors.push(BindError::UnknownProtocol {
                    user: user(),
                    protocol: protocol.clone(),
                    known: known.join(", "),
                });
                continue;
            };
            let port = &mut ports[number];
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
            let role = if is_sink { Role::Sets } else { Role::Reads };
            let named = (protocol.as_str(), port.side.protocol());
            match find_flag(user, named, port.side.party(), role, flag) {
                Ok(Named::Flag(flag)) if is_sink => {
                    if outgoing.len() <= event.index() {
                        outgoing.resize(event.index() + 1, None);
                    }
                    let port = number as u16;
                    outgoing[event.index()] = Some(Outgoing { port, flag });
                }
                Ok(Named::Flag(flag)) => errors.extend(port.add_source(place, event, flag)),
                Ok(Named::Abort) => {
                    port.aborted = Some(event);
                    port.abort_sources.push(place);
                }
                Err(error) => errors.push(error),
            }
        }
        if !errors.is_empty() {
            return Err(errors);
        }
        Ok(Self {
            executor: net.executor(),
            ports,
            outgoing: outgoing.into(),
            flags: flags.into(),
            refused: 0,
        })
    }

    /// Reads what the other parties did, evaluates the net within `budget`, and sets the flags of
    /// full sinks. Events of sinks that are not flags go to `send`, which returns whether it takes
    /// them; otherwise the sink stays full. Real time if `send` is.
    pub fn step(&mut self, budget: Budget, mut send: impl FnMut(EventId) -> bool) -> Progress {
        let read = (0..self.ports.len()).map(|number| self.read(number)).sum();
        self.offer_held();
        let evaluation = self.executor.evaluate(budget);
        let mut newly = self.drain(&mut send);
        let mut set = newly;
        while newly > 0 {
            // A flag that was set can make another one the next, which was looked at before.
            newly = self.drain(|_| false);
            set += newly;
        }
        let unread = { self.ports.iter() }.any(|port| port.can_read(&self.executor));
        let offerable = { self.ports.iter() }.any(|port| {
            let mut flags = port.incoming.iter().zip(0..);
            flags.any(|(held, flag)| held.held > 0 && port.can_fill(FlagId(flag), &self.executor))
        });
        Progress {
            read,
            evaluation,
            set,
            // Sinks that were emptied can enable transitions.
            remaining: unread || offerable || self.executor.has_work(),
        }
    }

    /// Lets an event that is no flag wait for the sources bound to it.
    pub fn offer(&mut self, event: EventId) -> Result<(), OfferError> {
        if is_flag(&self.flags, event) {
            return Err(OfferError::Flag(event));
        }
        self.executor.offer(event)
    }

    /// The net's executor.
    pub fn executor(&self) -> &Executor {
        &self.executor
    }

    /// The names of the protocols, in the order given.
    pub fn names(&self) -> impl ExactSizeIterator<Item = &str> {
        self.ports.iter().map(|port| &*port.name)
    }

    /// This party's side of the protocol called `name`. Searches.
    pub fn side(&self, name: &str) -> Option<&S> {
        let port = self.ports.iter().find(|port| *port.name == *name)?;
        Some(&port.side)
    }

    /// As [`side`](Self::side), to merge levels into it. Flags are set by the net.
    pub fn side_mut(&mut self, name: &str) -> Option<&mut S> {
        let port = self.ports.iter_mut().find(|port| *port.name == *name)?;
        Some(&mut port.side)
    }

    /// How many flags of the protocol called `name` were read and wait for full sources.
    pub fn held(&self, name: &str) -> u32 {
        let port = self.ports.iter().find(|port| *port.name == *name);
        let flags = port.into_iter().flat_map(|port| &port.incoming);
        flags.map(|incoming| u32::from(incoming.held)).sum()
    }

    /// How many runs of the protocol called `name` the other party has aborted.
    pub fn aborts(&self, name: &str) -> u64 {
        let port = self.ports.iter().find(|port| *port.name == *name);
        port.map_or(0, |port| port.aborts)
    }

    /// The flags of full sinks that their protocols did not take, with the protocol's name and the
    /// reason. Some wait for their turn; one that is out of order at this party's turn is a fault of
    /// the net, which analysis finds before it runs.
    pub fn refusals(&self) -> impl Iterator<Item = (&str, FlagId, SetError)> {
        self.ports.iter().filter_map(|port| {
            let (flag, error) = port.refusal?;
            Some((&*port.name, flag, error))
        })
    }

    /// How often a flag of a full sink was not taken, since the binding was made; trying the same
    /// flag again for the same reason does not count.
    pub fn refused(&self) -> u64 {
        self.refused
    }

    /// Gives up all runs and goes back to the initial marking. Events that are no flags stay, whether
    /// they wait, stand in sources or are to be sent: they belong to no run. Only the keeper of all protocols may;
    /// for others nothing changes. A protocol without a further run number stays where it is.
    pub fn abort(&mut self) -> Result<(), AbortError> {
        let keeps = |port: &Port<S>| port.side.protocol().keeper() == Some(port.side.party());
        if !self.ports.iter().all(keeps) {
            return Err(AbortError::NotKeeper);
        }
        let mut result = Ok(());
        for port in &mut self.ports {
            result = result.and(port.side.abort().map(|_| ()));
            port.forget();
        }
        let flags = &self.flags;
        self.executor.reset_but(|event| !is_flag(flags, event));
        result
    }

    /// Gives the protocol sides back, with their names.
    pub fn into_sides(self) -> impl Iterator<Item = (Box<str>, S)> {
        self.ports.into_iter().map(|port| (port.name, port.side))
    }

    /// Reads at most as many flags as one run has, and nothing behind an abort that the net has not
    /// dealt with: a net has no priorities, so what belongs to the next run could overtake it. Returns
    /// how many changes were read.
    fn read(&mut self, number: usize) -> u32 {
        for read in 0..u32::from(self.ports[number].longest_run) {
            let port = &mut self.ports[number];
            if !port.can_read(&self.executor) {
                return read;
            }
            // The other party may have aborted since.
            match port.side.poll() {
                None => return read,
                Some(Change::Flag(flag)) => {
                    let incoming = &mut port.incoming[flag.index()];
                    incoming.held += u8::from(incoming.event.is_some());
                }
                Some(Change::Aborted) => {
                    port.aborts += 1;
                    self.void(number);
                }
            }
        }
        self.ports[number].longest_run.into()
    }

    /// Takes back what belongs to the aborted run of a protocol, and offers the abort.
    fn void(&mut self, number: usize) {
        let Self {
            executor,
            ports,
            outgoing,
            ..
        } = self;
        let port = &mut ports[number];
        port.forget();
        executor.drain_sinks(|event| {
            let flag = outgoing.get(event.index()).copied().flatten();
            flag.is_some_and(|flag| usize::from(flag.port) == number)
        });
        for &(_, source) in &port.sources {
            executor.void_source(source);
        }
        if let Some(event) = port.aborted {
            // A full queue of aborts has told the net already; the executor counts the refusal.
            let _ = executor.offer(event);
        }
    }

    /// Offers what was read to sources that can take it at once, so that nothing waits in the
    /// executor, where an abort could not take it back.
    fn offer_held(&mut self) {
        for port in &mut self.ports {
            for index in 0..port.incoming.len() {
                let Incoming { event, held } = port.incoming[index];
                if let Some(event) = event
                    && held > 0
                    && port.can_fill(FlagId(index as u16), &self.executor)
                    && self.executor.offer(event).is_ok()
                {
                    port.incoming[index].held -= 1;
                }
            }
        }
    }

    /// Shows each full sink to its protocol or to `send`; how many flags were set.
    fn drain(&mut self, mut send: impl FnMut(EventId) -> bool) -> u32 {
        let Self {
            executor,
            ports,
            outgoing,
            refused,
            ..
        } = self;
        let mut set = 0;
        executor.drain_sinks(|event| {
            let Some(Outgoing { port, flag }) = outgoing.get(event.index()).copied().flatten()
            else {
                return send(event);
            };
            let port = &mut ports[usize::from(port)];
            let result = port.side.set(flag);
            match result {
                Ok(()) => {
                    set += 1;
                    port.refusal = port.refusal.filter(|&(refused, _)| refused != flag);
                }
                Err(error) if port.refusal != Some((flag, error)) => {
                    port.refusal = Some((flag, error));
                    *refused += 1;
                }
                Err(_) => {}
            }
            result.is_ok()
        });
        set
    }
}

fn is_flag(flags: &[bool], event: EventId) -> bool {
    flags.get(event.index()).is_some_and(|&is_flag| is_flag)
}

impl<S: Side> Port<S> {
    fn new(name: Box<str>, side: S) -> Self {
        let flags = side.protocol().flags().count();
        Self {
            name,
            incoming: vec![Incoming::default(); flags].into(),
            aborted: None,
            abort_sources: Vec::new(),
            sources: Vec::new(),
            longest_run: longest_run(side.protocol()),
            aborts: 0,
            refusal: None,
            side,
        }
    }

    /// Lets `flag`, whose event is `event`, fill `place` too.
    fn add_source(&mut self, place: PlaceId, event: EventId, flag: FlagId) -> Option<BindError> {
        let protocol = self.side.protocol();
        let abortable = protocol.keeper() == Some(self.side.party().other());
        let first = self.incoming[flag.index()].event.replace(event).is_none();
        self.sources.push((flag, place));
        (abortable && !first).then(|| BindError::SeveralSources {
            protocol: self.name.to_string(),
            flag: protocol.flag_name(flag).to_owned(),
        })
    }

    /// Whether there is something to read that may be read now.
    fn can_read(&self, executor: &Executor) -> bool {
        let is_unread = |&place: &PlaceId| executor.is_marked(place) || executor.waiting(place) > 0;
        if self.abort_sources.iter().any(is_unread) {
            return false;
        }
        match self.side.peek() {
            None => false,
            Some(Change::Aborted) => true,
            Some(Change::Flag(flag)) => {
                let Incoming { event, held } = self.incoming[flag.index()];
                event.is_none() || held < MAX_HELD
            }
        }
    }

    /// Whether a source of `flag` would be filled by the next evaluation, if the flag were offered.
    fn can_fill(&self, flag: FlagId, executor: &Executor) -> bool {
        let mut sources = self.sources.iter().filter(|&&(of, _)| of == flag);
        sources.any(|&(_, place)| !executor.is_marked(place) && executor.waiting(place) == 0)
    }

    /// Forgets what belongs to a run that is over.
    fn forget(&mut self) {
        self.incoming.iter_mut().for_each(|flag| flag.held = 0);
        self.refusal = None;
    }
}
