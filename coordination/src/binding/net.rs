//! A net and one protocol side per robot.

use std::sync::Arc;

use super::error::BindError;
use super::proved::{Standing, check_proof};
use super::wiring::{MAX_HELD, Outgoing, Port, Wiring};
use crate::analysis::Proof;
use crate::event::EventId;
use crate::petri::{Budget, Evaluation, Executor, Net, OfferError, PlaceId, TransitionId};
use crate::protocol::{AbortError, Change, FlagId, SetError, Side};

/// What one call of [`NetBinding::step`] did.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
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

/// A running net whose sources and sinks are flags of protocols; see [the module](super).
///
/// Its state is what the [analysis](crate::analysis) has looked at: the marked places, how many events
/// wait for each source, and up to where each side has read or set flags.
#[derive(Clone, Debug)]
pub struct NetBinding<S> {
    executor: Executor,
    pub(super) sides: Box<[S]>,
    pub(super) wiring: Wiring,
    refused: u64,
    /// Somebody has had the sides in their hands, and nobody has looked at them since.
    pub(super) lent: bool,
}

impl<S: Side> NetBinding<S> {
    /// The most events of one flag that wait for a source of it. More are not read; a net with a proof
    /// never comes to that.
    pub const MAX_HELD: u8 = MAX_HELD;

    /// Binds `net`, in its initial marking, to protocols under the names that the net's bindings use.
    /// Allocates.
    ///
    /// # Errors
    /// All that does not fit. The proof must be one of this net, with these protocols and parties, and
    /// reach the positions of the sides; else two robots could both be let in.
    pub fn new<N: Into<Box<str>>>(
        proof: &Proof,
        net: &Net,
        sides: impl IntoIterator<Item = (N, S)>,
    ) -> Result<Self, Vec<BindError>> {
        Self::bind(net, sides)?.proved(proof)
    }

    /// As [`new`](Self::new), where a net of the past has stood: `standing` and the sides are from its
    /// journal.
    ///
    /// # Errors
    /// As [`new`](Self::new); and if the proof does not reach this state.
    pub fn resume<N: Into<Box<str>>>(
        proof: &Proof,
        net: &Net,
        sides: impl IntoIterator<Item = (N, S)>,
        standing: &Standing,
    ) -> Result<Self, Vec<BindError>> {
        let mut binding = Self::bind(net, sides)?;
        standing.restore(&mut binding.executor)?;
        binding.proved(proof)
    }

    /// As [`new`](Self::new), of a net of which nothing is known: for tests of what such a net does. Only this crate's
    /// tests and builds with the feature `unproved` have it.
    ///
    /// # Errors
    /// All that does not fit.
    #[cfg(any(test, feature = "unproved"))]
    pub fn unproved<N: Into<Box<str>>>(
        net: &Net,
        sides: impl IntoIterator<Item = (N, S)>,
    ) -> Result<Self, Vec<BindError>> {
        Self::bind(net, sides)
    }

    fn proved(mut self, proof: &Proof) -> Result<Self, Vec<BindError>> {
        check_proof(proof, &self.executor, &self.wiring, &self.sides)?;
        for port in &mut self.wiring.ports {
            if let Some(used) = { proof.uses().iter() }.find(|used| *used.name == *port.name) {
                port.protocol = Arc::clone(&used.protocol);
            }
        }
        Ok(self)
    }

    fn bind<N: Into<Box<str>>>(
        net: &Net,
        sides: impl IntoIterator<Item = (N, S)>,
    ) -> Result<Self, Vec<BindError>> {
        let (names, sides): (Vec<Box<str>>, Vec<S>) = { sides.into_iter() }
            .map(|(name, side)| (name.into(), side))
            .unzip();
        let wiring = Wiring::new(net, names, &sides)?;
        Ok(Self {
            executor: net.executor(),
            sides: sides.into(),
            wiring,
            refused: 0,
            lent: false,
        })
    }

    /// Reads what the other parties did, evaluates the net within `budget`, and sets the flags of
    /// full sinks. Events of sinks that are not flags go to `send`, which returns whether it takes
    /// them; otherwise the sink stays full. Does nothing while [`misfits`](Self::misfits) tells of a side. Real time if
    /// `send` and the sides are.
    pub fn step(&mut self, budget: Budget, send: impl FnMut(EventId) -> bool) -> Progress {
        self.run(send, |executor| executor.evaluate(budget))
    }

    /// As [`step`](Self::step), and writes down what fired, in order. Fires no more than `trace` holds.
    pub fn step_traced(
        &mut self,
        budget: Budget,
        trace: &mut [TransitionId],
        send: impl FnMut(EventId) -> bool,
    ) -> Progress {
        self.run(send, |executor| executor.evaluate_traced(budget, trace))
    }

    #[inline]
    fn run(
        &mut self,
        mut send: impl FnMut(EventId) -> bool,
        evaluate: impl FnOnce(&mut Executor) -> Evaluation,
    ) -> Progress {
        if self.lent {
            let is_misfit = self.misfits().next().is_some();
            self.lent = is_misfit;
        }
        if self.lent {
            return Progress {
                read: 0,
                evaluation: Evaluation {
                    fired: 0,
                    remaining: false,
                },
                set: 0,
                remaining: false,
            };
        }
        let read = (0..self.sides.len()).map(|number| self.read(number)).sum();
        let evaluation = evaluate(&mut self.executor);
        let mut newly = self.drain(&mut send);
        let mut set = newly;
        while newly > 0 {
            // A flag that was set can make another one the next, which was looked at before.
            newly = self.drain(|_| false);
            set += newly;
        }
        let mut ports = self.wiring.ports.iter().zip(&self.sides);
        let unread = ports.any(|(port, side)| port.can_read(side, &self.executor));
        Progress {
            read,
            evaluation,
            set,
            // Sinks that were emptied can enable transitions.
            remaining: unread || self.executor.has_work(),
        }
    }

    /// Lets an event that is no flag wait for the sources bound to it.
    ///
    /// # Errors
    /// If it is a flag, no source is bound to it, or too many of it wait.
    pub fn offer(&mut self, event: EventId) -> Result<(), OfferError> {
        if self.wiring.is_flag(event) {
            return Err(OfferError::Flag(event));
        }
        self.executor.offer(event)
    }

    /// The net's executor.
    #[must_use]
    pub fn executor(&self) -> &Executor {
        &self.executor
    }

    /// Whether `proof` is one of this net and reaches the state that it is in now: so it stays, whatever
    /// happens, if it was made with that proof. Allocates; for tests.
    #[must_use]
    pub fn is_proved_by(&self, proof: &Proof) -> bool {
        check_proof(proof, &self.executor, &self.wiring, &self.sides).is_ok()
    }

    /// Where the net stands, to be stored together with the sides. Allocates.
    #[must_use]
    pub fn standing(&self) -> Standing {
        Standing::of(&self.executor)
    }

    /// The names of the protocols, in the order given.
    #[must_use]
    pub fn names(&self) -> impl ExactSizeIterator<Item = &str> {
        self.wiring.ports.iter().map(|port| &*port.name)
    }

    /// The flag that a source or a sink is bound to, and the number of its protocol in the order given.
    /// Searches.
    #[must_use]
    pub fn flag_of(&self, place: PlaceId) -> Option<(usize, FlagId)> {
        let mut ports = self.wiring.ports.iter().enumerate();
        ports.find_map(|(number, port)| {
            let mut all = port.sources.iter().chain(&port.sinks);
            let found = all.find(|&&(_, other)| other == place);
            found.map(|&(flag, _)| (number, flag))
        })
    }

    /// How many flags of the protocol called `name` were read and wait for full sources.
    #[must_use]
    pub fn held(&self, name: &str) -> u32 {
        let Some(port) = self.port(name) else {
            return 0;
        };
        let flags = (0..port.incoming.len()).map(|flag| FlagId(flag as u16));
        let most = |flag| {
            port.sources_of(flag)
                .map(|place| self.executor.waiting(place))
                .max()
        };
        flags.filter_map(most).sum()
    }

    /// How many runs of the protocol called `name` the other party has aborted.
    #[must_use]
    pub fn aborts(&self, name: &str) -> u64 {
        self.port(name).map_or(0, |port| port.aborts)
    }

    /// The flags of full sinks that their protocols did not take, with the protocol's name and the
    /// reason. Some wait for their turn; one that is out of order at this party's turn is a fault of
    /// the net, which analysis finds before it runs.
    pub fn refusals(&self) -> impl Iterator<Item = (&str, FlagId, SetError)> {
        self.wiring.ports.iter().filter_map(|port| {
            let (flag, error) = port.refusal?;
            Some((&*port.name, flag, error))
        })
    }

    /// How often a flag of a full sink was not taken, since the binding was made; trying the same
    /// flag again for the same reason does not count.
    #[must_use]
    pub fn refused(&self) -> u64 {
        self.refused
    }

    /// Gives up all runs and goes back to the initial marking. Events that are no flags stay, whether
    /// they wait, stand in sources or are to be sent: they belong to no run. A protocol without a
    /// further run number stays where it is.
    ///
    /// # Errors
    /// If this party is not the keeper of all protocols, or a side is of another protocol or party than the one that
    /// the net was bound to, and then nothing changes; or if no run number is left.
    pub fn abort(&mut self) -> Result<(), AbortError> {
        let mut all = self.wiring.ports.iter().zip(&self.sides);
        if self.lent && !all.all(|(port, side)| port.is_of(side)) {
            return Err(AbortError::OtherSide);
        }
        let keeps = |side: &S| side.protocol().keeper() == Some(side.party());
        if !self.sides.iter().all(keeps) {
            return Err(AbortError::NotKeeper);
        }
        // All sides are now where the net is, wherever somebody has brought them.
        self.lent = false;
        let mut result = Ok(());
        for (port, side) in self.wiring.ports.iter_mut().zip(&mut self.sides) {
            result = result.and(side.abort().map(|_| ()));
            port.refusal = None;
        }
        let wiring = &self.wiring;
        self.executor.reset_but(|event| !wiring.is_flag(event));
        result
    }

    pub(super) fn number(&self, name: &str) -> Option<usize> {
        let mut ports = self.wiring.ports.iter();
        ports.position(|port| *port.name == *name)
    }

    fn port(&self, name: &str) -> Option<&Port> {
        self.number(name).map(|number| &self.wiring.ports[number])
    }

    /// Reads at most as many flags as one run has, and nothing behind an abort that the net has not
    /// dealt with: a net has no priorities, so what belongs to the next run could overtake it. Each flag
    /// waits at once for every source bound to it, for each in a queue of its own, as the analysis has
    /// it. Returns how many changes were read.
    fn read(&mut self, number: usize) -> u32 {
        let longest = u32::from(self.wiring.ports[number].longest_run);
        for read in 0..longest {
            let port = &mut self.wiring.ports[number];
            if !port.can_read(&self.sides[number], &self.executor) {
                return read;
            }
            // The other party may have aborted since.
            match self.sides[number].poll() {
                None => return read,
                Some(Change::Flag(flag)) => {
                    if let Some(event) = port.incoming.get(flag.index()).copied().flatten() {
                        let offered = self.executor.offer(event);
                        debug_assert!(offered.is_ok(), "there is room: {offered:?}");
                    }
                }
                Some(Change::Aborted) => {
                    port.aborts += 1;
                    self.void(number);
                }
            }
        }
        longest
    }

    /// Takes back what belongs to the aborted run of a protocol, and offers the abort.
    fn void(&mut self, number: usize) {
        let Self {
            executor, wiring, ..
        } = self;
        let Wiring {
            ports, outgoing, ..
        } = wiring;
        let port = &mut ports[number];
        port.refusal = None;
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

    /// Shows each full sink to its protocol or to `send`; how many flags were set.
    fn drain(&mut self, mut send: impl FnMut(EventId) -> bool) -> u32 {
        let Self {
            executor,
            sides,
            wiring,
            refused,
            ..
        } = self;
        let Wiring {
            ports, outgoing, ..
        } = wiring;
        let mut set = 0;
        executor.drain_sinks(|event| {
            let Some(Outgoing { port, flag }) = outgoing.get(event.index()).copied().flatten()
            else {
                return send(event);
            };
            let number = usize::from(port);
            let port = &mut ports[number];
            let result = sides[number].set(flag);
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
