//! A net closed with its protocols: its states and the steps between them.

mod build;
mod describe;

use super::refusal::Reason;
use super::state::Layout;
use super::usage::Use;
use crate::petri::PlaceKind;
use crate::protocol::{FlagId, Position};
use describe::next_flags;

/// A step in numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Move {
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
    pub(super) fn is_own(self) -> bool {
        matches!(self, Self::Fire(_) | Self::Empty(_))
    }
}

/// Places of a transition.
#[derive(Debug, Default)]
struct Arcs {
    inputs: Vec<u32>,
    /// Inputs that are not outputs too.
    taken: Vec<u32>,
    /// Outputs that are not inputs too, sinks apart.
    internal: Vec<u32>,
    sinks: Vec<u32>,
}

/// A protocol and the places bound to it.
#[derive(Debug)]
struct Bound {
    /// The protocol's positions, which states hold as indices.
    positions: Vec<Position>,
    /// By flag: sources, each with the number of its counter of waiting events.
    sources: Vec<Vec<(u32, usize)>>,
    /// Sources of aborts, likewise.
    aborts: Vec<(u32, usize)>,
    /// Sinks and their flags.
    sinks: Vec<(u32, FlagId)>,
}

/// What a place is bound to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Outside {
    Nothing,
    Event,
    Flag(u16, FlagId),
    Abort(u16),
}

/// A named set of places, as words of a marking.
#[derive(Debug)]
struct Set {
    name: String,
    words: Vec<u64>,
}

/// The closed net.
#[derive(Debug)]
pub(super) struct Closed<'a> {
    uses: &'a [Use],
    places: Vec<String>,
    event_names: Vec<String>,
    kinds: Vec<PlaceKind>,
    outside: Vec<Outside>,
    /// For sources of flags: the number of the counter of waiting events.
    counters: Vec<Option<usize>>,
    transitions: Vec<(String, Arcs)>,
    /// By place: the transitions whose first input it is.
    first_input: Vec<Vec<u32>>,
    bound: Vec<Bound>,
    event_sources: Vec<u32>,
    event_sinks: Vec<u32>,
    exclusions: Vec<Set>,
    ends: Vec<Set>,
    /// Every place but sources of events.
    at_end: Vec<u64>,
    initial: Vec<u64>,
    max_waiting: u8,
    pub(super) layout: Layout,
}

impl<'a> Closed<'a> {
    pub(super) fn initial(&self) -> &[u64] {
        &self.initial
    }

    pub(super) fn transitions(&self) -> usize {
        self.transitions.len()
    }

    pub(super) fn transition_name(&self, transition: usize) -> &str {
        &self.transitions[transition].0
    }

    pub(super) fn protocols(&self) -> &[Use] {
        self.uses
    }

    pub(super) fn end_names(&self) -> impl Iterator<Item = &str> {
        self.ends.iter().map(|end| end.name.as_str())
    }

    /// Shows every step from `from` to `visit`, with the transition's or protocol's state behind it.
    /// Returns how many things were looked at. Stops at the first fault.
    pub(super) fn steps(
        &self,
        from: &[u64],
        scratch: &mut Vec<u64>,
        mut visit: impl FnMut(Move, &[u64]) -> Result<(), Box<Reason>>,
    ) -> Result<u64, Box<Reason>> {
        let mut looks = 1;
        for (word, &bits) in self.layout.marking(from).iter().enumerate() {
            let mut bits = bits;
            while bits != 0 {
                let place = word * 64 + bits.trailing_zeros() as usize;
                bits &= bits - 1;
                looks += self.first_input[place].len() as u64;
                for &transition in &self.first_input[place] {
                    if self.is_enabled(from, transition)? {
                        self.fire(from, transition, scratch);
                        visit(Move::Fire(transition), scratch)?;
                    }
                }
            }
        }
        for (number, (used, bound)) in (0..).zip(self.uses.iter().zip(&self.bound)) {
            looks += 1 + bound.sinks.len() as u64;
            self.protocol_steps(from, number, used, bound, scratch, &mut visit)?;
        }
        looks += (self.event_sources.len() + self.event_sinks.len()) as u64;
        for &source in &self.event_sources {
            if !self.layout.is_marked(from, source) {
                copy(scratch, from);
                self.layout.mark(scratch, source);
                visit(Move::Fill(source), scratch)?;
            }
        }
        for &sink in &self.event_sinks {
            if self.layout.is_marked(from, sink) {
                copy(scratch, from);
                self.layout.clear(scratch, sink);
                visit(Move::Empty(sink), scratch)?;
            }
        }
        Ok(looks)
    }

    fn is_enabled(&self, state: &[u64], transition: u32) -> Result<bool, Box<Reason>> {
        let (name, arcs) = &self.transitions[transition as usize];
        let marked = |&place: &u32| self.layout.is_marked(state, place);
        if !arcs.inputs.iter().all(marked) || arcs.sinks.iter().any(marked) {
            return Ok(false);
        }
        match arcs.internal.iter().find(|place| marked(place)) {
            None => Ok(true),
            Some(&place) => Err(Box::new(Reason::Unsafe {
                transition: name.clone(),
                place: self.places[place as usize].clone(),
            })),
        }
    }

    fn fire(&self, from: &[u64], transition: u32, state: &mut Vec<u64>) {
        copy(state, from);
        let arcs = &self.transitions[transition as usize].1;
        for &place in &arcs.taken {
            self.layout.clear(state, place);
            // What waits for an emptied source fills it again.
            if let Some(counter) = self.counters[place as usize] {
                let waiting = self.layout.waiting(state, counter);
                if waiting > 0 {
                    self.layout.set_waiting(state, counter, waiting - 1);
                    self.layout.mark(state, place);
                }
            }
        }
        for &place in arcs.internal.iter().chain(&arcs.sinks) {
            self.layout.mark(state, place);
        }
    }

    fn protocol_steps(
        &self,
        from: &[u64],
        number: u16,
        used: &Use,
        bound: &Bound,
        scratch: &mut Vec<u64>,
        visit: &mut impl FnMut(Move, &[u64]) -> Result<(), Box<Reason>>,
    ) -> Result<(), Box<Reason>> {
        let (protocol, index) = (&used.protocol, usize::from(number));
        let at = self.position(from, index);
        // What comes behind an abort stays unread until the net has dealt with the abort.
        let is_unread = |&(source, _): &(u32, usize)| self.layout.is_marked(from, source);
        let deaf = bound.aborts.iter().any(is_unread);
        for (flag, to) in protocol.next(at) {
            if !deaf && protocol.owner(flag) == Some(used.net_party.other()) {
                copy(scratch, from);
                self.layout.set_position(scratch, index, after(used, to));
                for &(source, counter) in &bound.sources[flag.index()] {
                    self.offer(scratch, source, counter)?;
                }
                visit(Move::Set(number, flag), scratch)?;
            }
        }
        for &(sink, flag) in &bound.sinks {
            if self.layout.is_marked(from, sink)
                && let Some(to) = protocol.after(at, flag)
            {
                copy(scratch, from);
                self.layout.set_position(scratch, index, after(used, to));
                self.layout.clear(scratch, sink);
                visit(Move::Empty(sink), scratch)?;
            }
        }
        if !deaf && !bound.aborts.is_empty() && at != Position::START {
            copy(scratch, from);
            self.layout.set_position(scratch, index, Position::START);
            // Void what belongs to the run.
            for &(source, counter) in bound.sources.iter().flatten() {
                self.layout.clear(scratch, source);
                self.layout.set_waiting(scratch, counter, 0);
            }
            for &(sink, _) in &bound.sinks {
                self.layout.clear(scratch, sink);
            }
            for &(source, counter) in &bound.aborts {
                self.offer(scratch, source, counter)?;
            }
            visit(Move::Abort(number), scratch)?;
        }
        Ok(())
    }

    /// Fills a source, or lets the event wait for it.
    fn offer(&self, state: &mut [u64], source: u32, counter: usize) -> Result<(), Box<Reason>> {
        if !self.layout.is_marked(state, source) {
            self.layout.mark(state, source);
            return Ok(());
        }
        let waiting = self.layout.waiting(state, counter);
        if waiting >= self.max_waiting {
            return Err(Box::new(Reason::Overflow {
                place: self.places[source as usize].clone(),
                event: self.event_names[source as usize].clone(),
                waiting,
            }));
        }
        self.layout.set_waiting(state, counter, waiting + 1);
        Ok(())
    }

    /// What is wrong with a state as such.
    pub(super) fn fault(&self, state: &[u64]) -> Option<Box<Reason>> {
        let marking = self.layout.marking(state);
        for exclusion in &self.exclusions {
            let both = |(a, b): (&u64, &u64)| (a & b).count_ones();
            if marking.iter().zip(&exclusion.words).map(both).sum::<u32>() > 1 {
                return Some(Box::new(Reason::Exclusion {
                    exclusion: exclusion.name.clone(),
                    places: self.names_of(marking.iter().zip(&exclusion.words).map(|(a, b)| a & b)),
                }));
            }
        }
        (0..self.uses.len()).find_map(|protocol| self.out_of_order(state, protocol))
    }

    /// From where the protocol is, marked sinks alone must lead to the flag of every marked sink.
    fn out_of_order(&self, state: &[u64], number: usize) -> Option<Box<Reason>> {
        let (used, bound) = (&self.uses[number], &self.bound[number]);
        let is_marked = |&&(sink, _): &&(u32, FlagId)| self.layout.is_marked(state, sink);
        let mut pending: Vec<(u32, FlagId)> =
            bound.sinks.iter().filter(is_marked).copied().collect();
        if pending.is_empty() {
            return None;
        }
        let mut reached = vec![self.position(state, number)];
        let mut at = Position::START;
        while let Some(position) = reached.pop() {
            at = position;
            pending.retain(|&(_, flag)| match used.protocol.after(position, flag) {
                Some(to) => {
                    reached.push(after(used, to));
                    false
                }
                None => true,
            });
        }
        let &(sink, flag) = pending.first()?;
        Some(Box::new(Reason::OutOfOrder {
            sink: self.places[sink as usize].clone(),
            protocol: used.name.clone(),
            flag: used.protocol.flag_name(flag).to_owned(),
            done: match at {
                Position::START => String::new(),
                at => used.protocol.describe(at).to_string(),
            },
            next: next_flags(used, at),
        }))
    }

    /// Which end a state is, if it is one.
    pub(super) fn end(&self, state: &[u64]) -> Option<usize> {
        if self.ends.is_empty()
            || !self.layout.nothing_waits(state)
            || (0..self.uses.len()).any(|number| !self.is_between_runs(state, number))
        {
            return None;
        }
        let marking = self.layout.marking(state);
        self.ends.iter().position(|end| {
            let places = marking.iter().zip(&self.at_end).map(|(a, b)| a & b);
            places.eq(end.words.iter().copied())
        })
    }

    /// Whether a protocol is between two runs.
    pub(super) fn is_between_runs(&self, state: &[u64], number: usize) -> bool {
        self.layout.position(state, number) == 0
    }

    fn position(&self, state: &[u64], number: usize) -> Position {
        let index = usize::from(self.layout.position(state, number));
        self.bound[number].positions[index]
    }
}

fn copy(to: &mut Vec<u64>, from: &[u64]) {
    to.clear();
    to.extend_from_slice(from);
}

/// A complete run makes room for the next.
fn after(used: &Use, to: Position) -> Position {
    if used.protocol.is_end(to) {
        Position::START
    } else {
        to
    }
}
