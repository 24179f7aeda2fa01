//! Runs a net.

use thiserror::Error;

use super::model::PlaceKind;
use super::net::{Net, PlaceId, TransitionId};
use crate::event::EventId;

/// How much one evaluation may do.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Budget {
    /// The most firings.
    pub firings: u32,
    /// The most rounds; in one round each transition fires at most once.
    pub rounds: u32,
}

impl Budget {
    /// At most one firing.
    pub const ONE: Self = Self {
        firings: 1,
        rounds: 1,
    };
    /// One round: until every enabled transition has fired.
    pub const ROUND: Self = Self {
        firings: u32::MAX,
        rounds: 1,
    };
}

impl Default for Budget {
    /// One round.
    fn default() -> Self {
        Self::ROUND
    }
}

/// What one evaluation did.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Evaluation {
    /// How many transitions fired.
    pub fired: u32,
    /// A transition is enabled, or an empty source has an event waiting: the next evaluation has
    /// something to do.
    pub remaining: bool,
}

/// Why an event was refused; nothing changed but the count of refusals.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
pub enum OfferError {
    /// No source of the net is bound to the event.
    #[error("no source is bound to event {}", .0.0)]
    UnknownEvent(EventId),
    /// As many events wait for a source as can wait.
    #[error("{} events already wait for source {}", Executor::MAX_WAITING, .0.0)]
    Full(PlaceId),
}

/// A marking names a place that the net does not have.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
#[error("the net has no place {}, only {places}", .place.0)]
pub struct WrongMarking {
    /// The unknown place.
    pub place: PlaceId,
    /// How many places the net has.
    pub places: usize,
}

/// Runs one net; see [the module](super).
#[derive(Clone, Debug)]
pub struct Executor {
    net: Net,
    marked: Box<[bool]>,
    /// By source.
    waiting: Box<[u32]>,
    fired: Box<[bool]>,
    last: usize,
    firings: u64,
    refused: u64,
}

impl Executor {
    /// The most events that wait for one source.
    pub const MAX_WAITING: u32 = u16::MAX as u32;

    pub(super) fn new(net: Net) -> Self {
        let structure = net.structure();
        let transitions = structure.transition_count();
        Self {
            marked: structure.places().map(|p| structure.marked(p)).collect(),
            waiting: vec![0; net.sources().len()].into(),
            fired: vec![false; transitions].into(),
            last: transitions - 1,
            firings: 0,
            refused: 0,
            net,
        }
    }

    /// The net that runs.
    pub fn net(&self) -> &Net {
        &self.net
    }

    /// Lets an event wait for every source bound to it; the next evaluation fills those that are
    /// empty. Real time.
    pub fn offer(&mut self, event: EventId) -> Result<(), OfferError> {
        let sources = self.net.filled_by(event);
        let full = sources
            .iter()
            .find(|&&(_, source)| self.waiting[usize::from(source)] >= Self::MAX_WAITING);
        let error = match full {
            None if sources.is_empty() => OfferError::UnknownEvent(event),
            None => {
                for &(_, source) in sources {
                    self.waiting[usize::from(source)] += 1;
                }
                return Ok(());
            }
            Some(&(_, source)) => OfferError::Full(self.net.sources()[usize::from(source)].0),
        };
        self.refused += 1;
        Err(error)
    }

    /// Fills sources and fires transitions as far as `budget` allows. Real time.
    pub fn evaluate(&mut self, budget: Budget) -> Evaluation {
        self.run(budget, |_| {})
    }

    /// As [`evaluate`](Self::evaluate), and writes down what fired, in order. Fires no more than
    /// `trace` holds. Real time.
    pub fn evaluate_traced(&mut self, budget: Budget, trace: &mut [TransitionId]) -> Evaluation {
        let firings = u32::try_from(trace.len()).unwrap_or(u32::MAX);
        let budget = Budget {
            firings: budget.firings.min(firings),
            ..budget
        };
        let mut entries = trace.iter_mut();
        self.run(budget, |transition| {
            if let Some(entry) = entries.next() {
                *entry = transition;
            }
        })
    }

    fn run(&mut self, budget: Budget, mut on_fire: impl FnMut(TransitionId)) -> Evaluation {
        for (source, &(place, _)) in self.net.sources().iter().enumerate() {
            if self.waiting[source] > 0 && !self.marked[place.index()] {
                self.waiting[source] -= 1;
                self.marked[place.index()] = true;
            }
        }
        let mut fired = 0;
        self.fired.fill(false);
        let mut round = 1;
        while fired < budget.firings && round <= budget.rounds {
            match self.next(|this, t| this.enabled(t) && !this.fired[t]) {
                Some(t) => {
                    self.fire(t);
                    on_fire(TransitionId::from_index(t));
                    fired += 1;
                }
                None if self.next(Self::enabled).is_none() => break,
                None => {
                    round += 1;
                    self.fired.fill(false);
                }
            }
        }
        let sources = self.net.sources().iter().zip(&self.waiting);
        let fillable =
            { sources }.any(|(&(place, _), &waiting)| waiting > 0 && !self.marked[place.index()]);
        Evaluation {
            fired,
            remaining: fillable || self.next(Self::enabled).is_some(),
        }
    }

    fn next(&self, wanted: impl Fn(&Self, usize) -> bool) -> Option<usize> {
        let count = self.fired.len();
        (1..=count)
            .map(|step| (self.last + step) % count)
            .find(|&t| wanted(self, t))
    }

    fn enabled(&self, t: usize) -> bool {
        let structure = self.net.structure();
        let t = TransitionId::from_index(t);
        let inputs = structure.inputs(t);
        inputs.iter().all(|p| self.marked[p.index()])
            && (structure.outputs(t).iter()).all(|p| !self.marked[p.index()] || inputs.contains(p))
    }

    fn fire(&mut self, t: usize) {
        let id = TransitionId::from_index(t);
        for p in self.net.structure().inputs(id) {
            self.marked[p.index()] = false;
        }
        for p in self.net.structure().outputs(id) {
            self.marked[p.index()] = true;
        }
        self.fired[t] = true;
        self.last = t;
        self.firings += 1;
    }

    /// The full sinks with the events that they produce. Real time.
    pub fn marked_sinks(&self) -> impl Iterator<Item = (PlaceId, EventId)> {
        let sinks = self.net.sinks().iter().copied();
        sinks.filter(|&(place, _)| self.is_marked(place))
    }

    /// Empties a sink, as its consumer does; `false`, and no change, if `sink` is empty or no sink.
    /// Real time.
    pub fn take(&mut self, sink: PlaceId) -> bool {
        let full = self.is_marked(sink) && self.net.structure().kind(sink) == PlaceKind::Sink;
        if full {
            self.marked[sink.index()] = false;
        }
        full
    }

    /// Shows the event of each full sink to `accept` and empties the sink if that returns `true`;
    /// otherwise the sink stays full. Returns how many were emptied. Real time if `accept` is.
    pub fn drain_sinks(&mut self, mut accept: impl FnMut(EventId) -> bool) -> usize {
        let mut taken = 0;
        for &(place, event) in self.net.sinks() {
            if self.marked[place.index()] && accept(event) {
                self.marked[place.index()] = false;
                taken += 1;
            }
        }
        taken
    }

    /// Whether `place` is marked; `false` for a place of another net. Real time.
    pub fn is_marked(&self, place: PlaceId) -> bool {
        self.marked.get(place.index()).is_some_and(|&marked| marked)
    }

    /// The marked places, in the model's order. Looks at every place.
    pub fn marking(&self) -> impl Iterator<Item = PlaceId> {
        self.net.places().filter(|&place| self.is_marked(place))
    }

    /// Marks exactly `places`. Waiting events stay, and so does where the next choice begins. After
    /// an error nothing has changed. Looks at every place.
    pub fn set_marking(&mut self, places: &[PlaceId]) -> Result<(), WrongMarking> {
        let count = self.marked.len();
        if let Some(&place) = places.iter().find(|place| place.index() >= count) {
            return Err(WrongMarking {
                place,
                places: count,
            });
        }
        self.marked.fill(false);
        for place in places {
            self.marked[place.index()] = true;
        }
        Ok(())
    }

    /// Back to the initial marking, with nothing waiting; the counters keep counting. Looks at
    /// every place.
    pub fn reset(&mut self) {
        let structure = self.net.structure();
        for place in structure.places() {
            self.marked[place.index()] = structure.marked(place);
        }
        self.waiting.fill(0);
        self.last = self.fired.len() - 1;
    }

    /// How many events wait for `source`; 0 if it is no source. Real time.
    pub fn waiting(&self, source: PlaceId) -> u32 {
        let sources = self.net.sources();
        let found = sources.binary_search_by_key(&source, |&(place, _)| place);
        found.map_or(0, |index| self.waiting[index])
    }

    /// How many transitions have fired since the executor was made.
    pub fn firings(&self) -> u64 {
        self.firings
    }

    /// How many offers were refused since the executor was made.
    pub fn refused(&self) -> u64 {
        self.refused
    }
}
