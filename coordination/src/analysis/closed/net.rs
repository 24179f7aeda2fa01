//! The parts of a closed net.

use super::super::flags::Outside;
use super::super::state::Layout;
use super::super::usage::Use;
use crate::petri::PlaceKind;
use crate::protocol::{FlagId, Position};

/// A step in numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(in crate::analysis) enum Move {
    /// This transition fires.
    Fire(u32),
    /// The other party of this protocol sets a flag.
    Set(u16, FlagId),
    /// This sink is emptied.
    Empty(u32),
    /// This source is filled.
    Fill(u32),
    /// The other party of this protocol gives up.
    Abort(u16),
}

impl Move {
    /// Whether the net and its surroundings do this by themselves, without any news from outside.
    pub(in crate::analysis) fn is_own(self) -> bool {
        matches!(self, Self::Fire(_) | Self::Empty(_))
    }
}

/// Places of a transition.
#[derive(Debug, Default)]
pub(super) struct Arcs {
    pub(super) inputs: Vec<u32>,
    /// Inputs that are not outputs too.
    pub(super) taken: Vec<u32>,
    /// Outputs that are not inputs too, sinks apart.
    pub(super) internal: Vec<u32>,
    pub(super) sinks: Vec<u32>,
}

/// A protocol and the places bound to it.
#[derive(Debug)]
pub(super) struct Bound {
    /// The protocol's positions, which states hold as indices.
    pub(super) positions: Vec<Position>,
    /// By flag: sources, each with the number of its counter of waiting events.
    pub(super) sources: Vec<Vec<(u32, usize)>>,
    /// Sources of aborts, likewise.
    pub(super) aborts: Vec<(u32, usize)>,
    /// Sinks and their flags.
    pub(super) sinks: Vec<(u32, FlagId)>,
}

/// A named set of places, as words of a marking.
#[derive(Debug)]
pub(super) struct Set {
    pub(super) name: String,
    pub(super) words: Vec<u64>,
}

/// The closed net.
#[derive(Debug)]
pub(in crate::analysis) struct Closed<'a> {
    pub(super) uses: &'a [Use],
    pub(super) places: Vec<String>,
    pub(super) event_names: Vec<String>,
    pub(super) kinds: Vec<PlaceKind>,
    pub(super) outside: Vec<Outside>,
    /// For sources of flags: the number of the counter of waiting events.
    pub(super) counters: Vec<Option<usize>>,
    pub(super) transitions: Vec<(String, Arcs)>,
    /// By place: the transitions whose first input it is.
    pub(super) first_input: Vec<Vec<u32>>,
    pub(super) bound: Vec<Bound>,
    pub(super) event_sources: Vec<u32>,
    pub(super) event_sinks: Vec<u32>,
    /// Those that are to be looked at.
    pub(super) exclusions: Vec<Set>,
    /// By place: whether it is known never to hold a second token.
    pub(super) safe: Vec<bool>,
    pub(super) ends: Vec<Set>,
    /// Every place but sources of events.
    pub(super) at_end: Vec<u64>,
    pub(super) initial: Vec<u64>,
    pub(super) max_waiting: u8,
    pub(super) endless: bool,
    pub(in crate::analysis) layout: Layout,
}

impl<'a> Closed<'a> {
    pub(in crate::analysis) fn initial(&self) -> &[u64] {
        &self.initial
    }

    pub(in crate::analysis) fn transitions(&self) -> usize {
        self.transitions.len()
    }

    pub(in crate::analysis) fn transition_name(&self, transition: usize) -> &str {
        &self.transitions[transition].0
    }

    /// Takes note of what need not be looked at any more: places that hold at most one token, and exclusions
    /// that hold.
    pub(in crate::analysis) fn know(
        &mut self,
        is_safe: impl Fn(&str) -> bool,
        holds: impl Fn(&str) -> bool,
    ) {
        self.safe = self.places.iter().map(|place| is_safe(place)).collect();
        self.exclusions.retain(|exclusion| !holds(&exclusion.name));
    }

    /// The number of the place with this name. Searches.
    pub(in crate::analysis) fn place_number(&self, name: &str) -> Option<u32> {
        let mut places = self.places.iter().zip(0..);
        places.find_map(|(place, number)| (place == name).then_some(number))
    }

    /// By place, for sources of flags: the number of the counter of waiting events.
    pub(in crate::analysis) fn counters(&self) -> &[Option<usize>] {
        &self.counters
    }

    /// Whether its transitions may fire for ever by themselves.
    pub(in crate::analysis) fn allows_endless(&self) -> bool {
        self.endless
    }

    pub(in crate::analysis) fn protocols(&self) -> &[Use] {
        self.uses
    }

    pub(in crate::analysis) fn end_names(&self) -> impl Iterator<Item = &str> {
        self.ends.iter().map(|end| end.name.as_str())
    }

    /// Whether a protocol is between two runs.
    pub(in crate::analysis) fn is_between_runs(&self, state: &[u64], number: usize) -> bool {
        self.layout.position(state, number) == 0
    }

    pub(super) fn position(&self, state: &[u64], number: usize) -> Position {
        let index = usize::from(self.layout.position(state, number));
        self.bound[number].positions[index]
    }
}
