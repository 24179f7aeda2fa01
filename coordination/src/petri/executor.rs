//! Runs a net.

use thiserror::Error;

use super::engine::State;
use super::evaluation::{Allowance, Budget, Evaluation};
use super::id::{PlaceId, TransitionId};
use super::net::Net;
use super::ports::Ports;
use crate::event::EventId;

/// Why an event was refused; nothing changed but the count of refusals.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum OfferError {
    /// No source of the net is bound to the event.
    #[error("no source is bound to event {}", .0.0)]
    UnknownEvent(EventId),
    /// The event stands for a flag, which only its protocol's other party sets.
    #[error("event {} is a flag of a protocol and cannot be offered", .0.0)]
    Flag(EventId),
    /// As many events wait for a source as can wait.
    #[error("{} events already wait for source {}", Executor::MAX_WAITING, .0.0)]
    Full(PlaceId),
}

/// A marking names a place that the net does not have.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
#[error("the net has no place {}, only {places}", .place.0)]
#[expect(missing_docs, reason = "the message says what each field is")]
pub struct WrongMarking {
    pub place: PlaceId,
    pub places: usize,
}

/// Runs one net; see [the module](super).
///
/// **Real time:** nothing here allocates but [`Net::executor`] and cloning. What looks at the whole
/// net says so; everything else costs what it touches.
#[derive(Clone, Debug)]
pub struct Executor {
    pub(super) net: Net,
    pub(super) state: State,
    pub(super) ports: Ports,
    search_limit: u32,
    pub(super) firings: u64,
    refused: u64,
}

impl Net {
    /// An executor in the initial marking. Not for real-time threads.
    #[must_use]
    pub fn executor(&self) -> Executor {
        Executor::new(self.clone())
    }
}

impl Executor {
    /// The most events that wait for one source.
    pub const MAX_WAITING: u32 = u16::MAX as u32;
    /// What [`limit_search`](Self::limit_search) is at first.
    pub const SEARCH_LIMIT: u32 = 256;
    /// Further groups of 64 transitions for each firing that the budget allows.
    pub const SEARCH_PER_FIRING: u32 = 64;

    fn new(net: Net) -> Self {
        let mut executor = Self {
            state: net.initial().clone(),
            ports: Ports::new(net.sources().len(), net.sinks().len()),
            search_limit: Self::SEARCH_LIMIT,
            firings: 0,
            refused: 0,
            net,
        };
        executor.restart_ports();
        executor
    }

    /// The net that runs.
    #[must_use]
    pub fn net(&self) -> &Net {
        &self.net
    }

    /// Limits how many groups of 64 transitions an evaluation of a large net may look at in vain, beside
    /// [`SEARCH_PER_FIRING`](Self::SEARCH_PER_FIRING) for each firing of its budget. One that has
    /// done so ends early, with work remaining, and the next goes on behind the last group. With the
    /// limit that it has at first, a net of up to 2,048 transitions never comes to that.
    pub fn limit_search(&mut self, groups: u32) {
        self.search_limit = groups;
    }

    fn looks(&self, firings: u32) -> u32 {
        let more = firings.saturating_mul(Self::SEARCH_PER_FIRING);
        self.search_limit.saturating_add(more)
    }

    /// Lets an event wait for every source bound to it; the next evaluation fills those that are
    /// empty.
    ///
    /// # Errors
    /// If no source is bound to the event, or one has [`MAX_WAITING`](Self::MAX_WAITING) events
    /// waiting; then no source takes it.
    pub fn offer(&mut self, event: EventId) -> Result<(), OfferError> {
        let filled = self.net.filled_by(event);
        let full = filled
            .iter()
            .find(|&&(_, source)| self.ports.waiting(source.into()) >= Self::MAX_WAITING);
        let error = match full {
            Some(&(_, source)) => OfferError::Full(self.net.sources()[usize::from(source)].0),
            None if filled.is_empty() => OfferError::UnknownEvent(event),
            None => {
                for &(_, source) in filled {
                    let (place, _) = self.net.sources()[usize::from(source)];
                    let is_empty = !self.state.is_marked(self.net.layout(), place);
                    self.ports.wait(source.into(), is_empty);
                }
                return Ok(());
            }
        };
        self.refused += 1;
        Err(error)
    }

    /// Fills sources and fires transitions as far as `budget` allows.
    #[inline]
    pub fn evaluate(&mut self, budget: Budget) -> Evaluation {
        self.run(budget, |_| {})
    }

    /// As [`evaluate`](Self::evaluate), and writes down what fired, in order. Fires no more than
    /// `trace` holds.
    pub fn evaluate_traced(&mut self, budget: Budget, trace: &mut [TransitionId]) -> Evaluation {
        let firings = u32::try_from(trace.len()).unwrap_or(u32::MAX);
        let budget = Budget {
            firings: budget.firings.min(firings),
            ..budget
        };
        let mut entries = trace.iter_mut();
        self.run(budget, |transition| {
            if let Some(entry) = entries.next() {
                *entry = TransitionId::from_index(transition);
            }
        })
    }

    #[inline(always)]
    fn run(&mut self, budget: Budget, mut on_fire: impl FnMut(usize)) -> Evaluation {
        if budget.firings == 1
            && budget.rounds > 0
            && let Some((fired, remaining)) = self.state.step(self.net.layout(), &mut self.ports)
        {
            on_fire(fired);
            self.firings = self.firings.wrapping_add(1);
            return Evaluation {
                fired: 1,
                remaining,
            };
        }
        self.run_rounds(budget, on_fire)
    }

    #[inline(never)]
    fn run_rounds(&mut self, budget: Budget, mut on_fire: impl FnMut(usize)) -> Evaluation {
        let looks = self.looks(budget.firings);
        let Self {
            net, state, ports, ..
        } = self;
        if budget.firings == 1
            && budget.rounds > 0
            && let Some((fired, remaining)) = state.step_in_blocks(net.layout(), ports, looks)
        {
            on_fire(fired);
            self.firings += 1;
            return Evaluation {
                fired: 1,
                remaining,
            };
        }
        if ports.can_fill() {
            fill_sources(net, state, ports);
        }
        let mut left = Allowance {
            firings: budget.firings,
            rounds: budget.rounds,
            looks,
        };
        let enabled = state.run(net.layout(), ports, &mut left, on_fire);
        let fired = budget.firings - left.firings;
        self.firings += u64::from(fired);
        Evaluation {
            fired,
            remaining: enabled || ports.can_fill(),
        }
    }

    /// What [`Evaluation::remaining`] would say now: whether the next evaluation has something to do.
    /// Nothing changes but notes about where to look first.
    pub fn has_work(&mut self) -> bool {
        let looks = self.looks(0);
        let Self {
            net, state, ports, ..
        } = self;
        let mut nothing = Allowance {
            firings: 0,
            rounds: 0,
            looks,
        };
        ports.can_fill() || state.run(net.layout(), ports, &mut nothing, |_| {})
    }

    /// The full sinks with the events that they produce, in the order in which they filled.
    #[must_use]
    pub fn marked_sinks(&self) -> impl ExactSizeIterator<Item = (PlaceId, EventId)> {
        let full = self.ports.full().iter();
        full.map(|&sink| self.net.sinks()[usize::from(sink)])
    }

    /// Empties a sink, as its consumer does; `false`, and no change, if `sink` is empty or no sink.
    /// Looks at every full sink.
    pub fn take(&mut self, sink: PlaceId) -> bool {
        self.empty_sinks(|place, _| place == sink) > 0
    }

    /// Shows the event of each full sink, in the order in which they filled, to `accept`, and
    /// empties the sink if that returns `true`; otherwise it stays full. Returns how many were
    /// emptied.
    pub fn drain_sinks(&mut self, mut accept: impl FnMut(EventId) -> bool) -> usize {
        self.empty_sinks(|_, event| accept(event))
    }

    fn empty_sinks(&mut self, mut accept: impl FnMut(PlaceId, EventId) -> bool) -> usize {
        let Self {
            net, state, ports, ..
        } = self;
        ports.empty_sinks(|sink| {
            let (place, event) = net.sinks()[sink];
            let accepted = accept(place, event);
            if accepted {
                state.flip(net.layout(), place);
            }
            !accepted
        })
    }

    /// Empties a source and forgets what waits for it; how many events that were, 0 if `source` is no
    /// source. Costs a look at all sources that are to be filled.
    pub fn void_source(&mut self, source: PlaceId) -> u32 {
        let sources = self.net.sources();
        let Ok(index) = sources.binary_search_by_key(&source, |&(place, _)| place) else {
            return 0;
        };
        let is_marked = self.state.is_marked(self.net.layout(), source);
        if is_marked {
            self.state.flip(self.net.layout(), source);
        }
        u32::from(is_marked) + self.ports.forget_waiting(index)
    }

    /// Whether `place` is marked; `false` for a place that the net does not have.
    #[must_use]
    pub fn is_marked(&self, place: PlaceId) -> bool {
        let known = place.index() < self.net.places().len();
        known && self.state.is_marked(self.net.layout(), place)
    }

    /// The marked places, in the model's order. Looks at every place.
    pub fn marking(&self) -> impl Iterator<Item = PlaceId> {
        self.net.places().filter(|&place| self.is_marked(place))
    }

    /// Marks exactly `places`. Waiting events stay, and so does where the next choice begins. After
    /// an error nothing has changed. Looks at every place.
    ///
    /// # Errors
    /// [`WrongMarking`] for the first place that the net does not have.
    pub fn set_marking(&mut self, places: &[PlaceId]) -> Result<(), WrongMarking> {
        let count = self.net.places().len();
        if let Some(&place) = places.iter().find(|place| place.index() >= count) {
            return Err(WrongMarking {
                place,
                places: count,
            });
        }
        let layout = self.net.layout();
        for place in self.net.places() {
            if self.state.is_marked(layout, place) {
                self.state.flip(layout, place);
            }
        }
        for &place in places {
            if !self.state.is_marked(layout, place) {
                self.state.flip(layout, place);
            }
        }
        self.restart_ports();
        Ok(())
    }

    /// Lets exactly `count` events wait for `source`; `false`, and no change, if it is no source or the
    /// count is above [`MAX_WAITING`](Self::MAX_WAITING). Looks at every source.
    pub fn set_waiting(&mut self, source: PlaceId, count: u32) -> bool {
        let sources = self.net.sources();
        let Ok(index) = sources.binary_search_by_key(&source, |&(place, _)| place) else {
            return false;
        };
        if count > Self::MAX_WAITING {
            return false;
        }
        let Self {
            net, state, ports, ..
        } = self;
        ports.set_waiting(index, count);
        ports.restart_sources(|source| !state.is_marked(net.layout(), net.sources()[source].0));
        true
    }

    /// Back to the initial marking, with nothing waiting; the counters keep counting. Looks at
    /// every place.
    pub fn reset(&mut self) {
        self.state.copy_from(self.net.initial());
        self.ports.forget();
        self.restart_ports();
    }

    /// As [`reset`](Self::reset), but events that `keeps` names stay: those that wait, and tokens in
    /// their sources and sinks. Where the next choice begins stays too.
    pub fn reset_but(&mut self, keeps: impl Fn(EventId) -> bool) {
        let Self {
            net, state, ports, ..
        } = self;
        let layout = net.layout();
        let find = |list: &[(PlaceId, EventId)], place| {
            let index = list
                .binary_search_by_key(&place, |&(place, _)| place)
                .ok()?;
            Some((index, list[index].1))
        };
        for place in net.places() {
            let sink = find(net.sinks(), place);
            let event = sink.or_else(|| find(net.sources(), place));
            let kept = event.is_some_and(|(_, event)| keeps(event));
            let before = state.is_marked(layout, place);
            let after = net.initial().is_marked(layout, place) || kept && before;
            if before != after {
                state.flip(layout, place);
            }
            if let Some((sink, _)) = sink
                && after
                && !before
            {
                ports.filled(sink);
            }
        }
        ports.empty_sinks(|sink| state.is_marked(layout, net.sinks()[sink].0));
        ports.forget_those(|source| !keeps(net.sources()[source].1));
        ports.restart_sources(|source| !state.is_marked(layout, net.sources()[source].0));
    }

    fn restart_ports(&mut self) {
        let Self {
            net, state, ports, ..
        } = self;
        let is_marked = |place| state.is_marked(net.layout(), place);
        ports.restart(
            |source| !is_marked(net.sources()[source].0),
            |sink| is_marked(net.sinks()[sink].0),
        );
    }

    /// How many events wait for `source`; 0 if it is no source.
    #[must_use]
    pub fn waiting(&self, source: PlaceId) -> u32 {
        let sources = self.net.sources();
        let found = sources.binary_search_by_key(&source, |&(place, _)| place);
        found.map_or(0, |index| self.ports.waiting(index))
    }

    /// How many transitions have fired since the executor was made.
    #[must_use]
    pub fn firings(&self) -> u64 {
        self.firings
    }

    /// How many offers were refused since the executor was made.
    #[must_use]
    pub fn refused(&self) -> u64 {
        self.refused
    }
}

/// Fills empty sources with what waits for them.
pub(super) fn fill_sources(net: &Net, state: &mut State, ports: &mut Ports) {
    while let Some(source) = ports.next_to_fill() {
        state.flip(net.layout(), net.sources()[source].0);
    }
}
