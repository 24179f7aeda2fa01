//! Tokens of a net, and how flags of protocols fill and empty its ports.

use std::sync::Arc;

use contract::protocols::{MEDIATOR_PARTY, ROBOT_PARTY};
use coordination::petri::{Binding, NetModel, PlaceKind};
use coordination::protocol::{FlagId, Position, Protocol};

/// Which places are marked, one bit each; for which sources one more flag waits; and what has fired last: behind that the executor looks
/// for the next one.
#[derive(Clone, Debug, Default, PartialEq, Eq, Hash)]
pub(super) struct Marks {
    bits: Vec<u64>,
    waits: Vec<u64>,
    last: Option<u16>,
}

impl Marks {
    pub(super) fn has(&self, place: usize) -> bool {
        self.bits[place / 64] >> (place % 64) & 1 == 1
    }

    pub(super) fn set(&mut self, place: usize, marked: bool) {
        let bit = 1 << (place % 64);
        if marked {
            self.bits[place / 64] |= bit;
        } else {
            self.bits[place / 64] &= !bit;
        }
    }

    fn waits(&self, source: usize) -> bool {
        self.waits[source / 64] >> (source % 64) & 1 == 1
    }

    /// A flag fills the source, or waits until it is empty.
    fn offer(&mut self, source: usize) {
        if self.has(source) {
            self.waits[source / 64] |= 1 << (source % 64);
        } else {
            self.set(source, true);
        }
    }

    /// What waits fills its source, where that is empty.
    pub(super) fn refill(&mut self) {
        for (bits, waits) in self.bits.iter_mut().zip(&mut self.waits) {
            let fills = *waits & !*bits;
            *bits |= fills;
            *waits &= !fills;
        }
    }
}

/// One of a net's transitions, by places.
struct Transition {
    name: String,
    inputs: Vec<usize>,
    outputs: Vec<usize>,
    /// No other one takes any of its inputs or fills any of its sinks, and such ones do not go round: that it fires first takes
    /// nothing from anybody.
    free: bool,
}

/// The token game of a net.
pub(super) struct Tokens {
    begin: Marks,
    transitions: Vec<Transition>,
    /// Internal places of each declared end.
    ends: Vec<Vec<bool>>,
    internal: Vec<bool>,
}

impl Tokens {
    pub(super) fn of(model: &NetModel) -> Self {
        let place = |name: &str| model.places().position(|place| place.name == name);
        let set = |names: &[&str]| {
            let mut marks = vec![false; model.places().len()];
            for index in names.iter().filter_map(|name| place(name)) {
                marks[index] = true;
            }
            marks
        };
        let words = model.places().len().div_ceil(64);
        let mut begin = Marks {
            bits: vec![0; words],
            waits: vec![0; words],
            last: None,
        };
        for (number, place) in model.places().enumerate() {
            begin.set(number, place.marked);
        }
        Self {
            begin,
            transitions: transitions(model),
            ends: model.ends().map(|end| set(&end.places)).collect(),
            internal: model
                .places()
                .map(|place| place.binding.is_none())
                .collect(),
        }
    }

    /// As it begins.
    pub(super) fn begin(&self) -> Marks {
        self.begin.clone()
    }

    /// Transitions that are enabled: all of them, the executor's choice first, or that alone if it takes nothing from any other.
    pub(super) fn enabled(&self, marks: &Marks) -> Vec<usize> {
        let behind = marks.last.map_or(0, |last| usize::from(last) + 1);
        let around = (behind..self.transitions.len()).chain(0..behind);
        let mut enabled = around.filter(|&number| self.is_enabled(number, marks));
        match enabled.next() {
            Some(choice) if self.transitions[choice].free => vec![choice],
            choice => choice.into_iter().chain(enabled).collect(),
        }
    }

    fn is_enabled(&self, transition: usize, marks: &Marks) -> bool {
        let own = &self.transitions[transition];
        let takes = |place: &&usize| !own.inputs.contains(place);
        let mut fills = own.outputs.iter().filter(takes);
        own.inputs.iter().all(|&place| marks.has(place)) && fills.all(|&place| !marks.has(place))
    }

    /// It is enabled, but the executor fires another one before it, as long as that one is enabled.
    pub(super) fn is_out_of_turn(&self, transition: usize, marks: &Marks) -> bool {
        self.enabled(marks).first() != Some(&transition)
    }

    pub(super) fn fire(&self, marks: &mut Marks, transition: usize) {
        let own = &self.transitions[transition];
        own.inputs.iter().for_each(|&place| marks.set(place, false));
        own.outputs.iter().for_each(|&place| marks.set(place, true));
        marks.last = Some(transition as u16);
    }

    /// See [`enabled`](Self::enabled).
    pub(super) fn is_free(&self, transition: usize) -> bool {
        self.transitions[transition].free
    }

    pub(super) fn name(&self, transition: usize) -> &str {
        &self.transitions[transition].name
    }

    /// It declares where it may end.
    pub(super) fn has_ends(&self) -> bool {
        !self.ends.is_empty()
    }

    /// Its internal places are those of a declared end.
    pub(super) fn are_at_an_end(&self, marks: &Marks) -> bool {
        self.ends.iter().any(|end| {
            let mut internal = self.internal.iter().enumerate();
            internal.all(|(place, internal)| !internal || marks.has(place) == end[place])
        })
    }
}

/// How far a protocol is: what both have set, and what the mediator has read of that.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) struct Progress {
    pub(super) set: Position,
    pub(super) read: Position,
}

impl Progress {
    pub(super) const START: Self = Self {
        set: Position::START,
        read: Position::START,
    };
}

/// The places that the flags of a role's protocol fill and empty.
pub(super) struct Ports {
    pub(super) protocol: Arc<Protocol>,
    /// By flag.
    sources: Vec<Vec<usize>>,
    sinks: Vec<(usize, FlagId)>,
}

impl Ports {
    pub(super) fn of(model: &NetModel, role: &str, protocol: &Arc<Protocol>) -> Self {
        let bound = |flag: &str| {
            let binding = Binding::flag(role, flag);
            let places = model.places().enumerate();
            places
                .filter(|(_, place)| place.binding == Some(&binding))
                .map(|(number, _)| number)
                .collect::<Vec<usize>>()
        };
        let of_mediator = protocol.flags().filter(|flag| flag.2 == MEDIATOR_PARTY);
        Self {
            sources: { protocol.flags() }
                .map(|(_, flag, party)| match party {
                    ROBOT_PARTY => bound(flag),
                    _ => Vec::new(),
                })
                .collect(),
            sinks: of_mediator
                .flat_map(|(id, flag, _)| bound(flag).into_iter().map(move |sink| (sink, id)))
                .collect(),
            protocol: Arc::clone(protocol),
        }
    }

    /// Reads the robot's next flag into all its sources, unless one waits there already.
    pub(super) fn read(&self, marks: &mut Marks, at: &mut Progress) -> bool {
        let Some((flag, next)) = self.protocol.towards(at.read, at.set) else {
            return false;
        };
        let sources = &self.sources[flag.index()];
        let is_open = sources.iter().all(|&source| !marks.waits(source));
        if is_open {
            sources.iter().for_each(|&source| marks.offer(source));
            at.read = next;
        }
        is_open
    }

    /// Sets the mediator's flag of a full sink, where it is next.
    pub(super) fn tell(&self, marks: &mut Marks, at: &mut Progress) -> Option<FlagId> {
        if at.set != at.read {
            return None;
        }
        let full = self.sinks.iter().filter(|(sink, _)| marks.has(*sink));
        let next = |&(sink, flag)| Some((sink, flag, self.protocol.after(at.set, flag)?));
        let (sink, flag, next) = full.into_iter().find_map(next)?;
        marks.set(sink, false);
        (at.set, at.read) = (next, next);
        Some(flag)
    }
}

fn transitions(model: &NetModel) -> Vec<Transition> {
    let place = |name: &&str| model.places().position(|place| place.name == *name);
    let kinds: Vec<PlaceKind> = model.places().map(|place| place.kind).collect();
    let is_sink = |place: usize| kinds[place] == PlaceKind::Sink;
    let all: Vec<Transition> = { model.transitions() }
        .map(|own| Transition {
            name: own.name.to_owned(),
            inputs: own.inputs.iter().filter_map(place).collect(),
            outputs: own.outputs.iter().filter_map(place).collect(),
            free: false,
        })
        .collect();
    let alone = |number: usize| {
        let own = &all[number];
        let mut others = all.iter().enumerate().filter(|(other, _)| *other != number);
        !others.any(|(_, other)| {
            let takes = other.inputs.iter().any(|place| own.inputs.contains(place));
            let mut fills = { other.outputs.iter() }.filter(|place| own.outputs.contains(place));
            takes || fills.any(|&place| is_sink(place))
        })
    };
    let mut free: Vec<bool> = (0..all.len()).map(alone).collect();
    // Those that are on no way round remain when what leads to none of them is left out, again and again.
    let mut round = free.clone();
    loop {
        let leads_on = |number: usize| {
            let mut others = all.iter().zip(&round).filter(|(_, round)| **round);
            others.any(|(other, _)| {
                { other.inputs.iter() }.any(|own| all[number].outputs.contains(own))
            })
        };
        let Some(end) = (0..all.len()).find(|&number| round[number] && !leads_on(number)) else {
            break;
        };
        round[end] = false;
    }
    for (free, round) in free.iter_mut().zip(round) {
        *free &= !round;
    }
    { all.into_iter().zip(free) }
        .map(|(own, free)| Transition { free, ..own })
        .collect()
}
