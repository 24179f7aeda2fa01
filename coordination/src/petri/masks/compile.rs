//! From a checked model to masks; see [masks](super).

use super::cuts::Cuts;
use super::layout::{BITS, Layout, Pair, Row};
use super::state::{Block, State};
use crate::event::EventId;
use crate::petri::bits::lowest;
use crate::petri::demand::{Demand, for_conditions};
use crate::petri::id::PlaceId;
use crate::petri::model::{Arcs, PlaceKind, Structure};
use crate::petri::ports::PortChange;
use crate::petri::span::{Span, span};

/// The layout of `structure`, and its state in the initial marking; nothing if it does not fit. `sources`
/// and `sinks` are in the order of their places.
pub(in crate::petri) fn compile(
    structure: &Structure,
    sources: &[(PlaceId, EventId)],
    sinks: &[(PlaceId, EventId)],
) -> Option<(Layout, State)> {
    let (mut layout, state) =
        if structure.place_count() <= BITS && structure.transition_count() <= BITS {
            one_word(structure)
        } else {
            several_words(structure, &Cuts::of(structure)?)
        };
    if !sources.is_empty() || !sinks.is_empty() {
        add_ports(structure, [sources, sinks], &mut layout);
    }
    Some((layout, state))
}

/// In the place of a net that does not fit.
pub(in crate::petri) fn nothing() -> (Layout, State) {
    let layout = Layout {
        rows: Box::default(),
        pairs: Box::default(),
        spots: Box::default(),
        users: Box::default(),
        has_ports: false,
        ports_of: Box::default(),
        port_changes: Box::default(),
    };
    let state = State::new(Block::new(0, 1), Box::default(), 0);
    (layout, state)
}

/// Calls `each` with the place and the demand of each condition.
#[inline(always)]
fn for_arcs(arcs: Arcs<'_>, mut each: impl FnMut(PlaceId, Demand)) {
    if arcs.has_self_loop {
        for_conditions(arcs, each);
        return;
    }
    let (inputs, outputs) = arcs.places.split_at(arcs.inputs);
    for &place in inputs {
        each(place, Demand::Marked);
    }
    for &place in outputs {
        each(place, Demand::Empty);
    }
}

impl Row {
    #[inline(always)]
    fn add(&mut self, bit: u64, demand: Demand) {
        self.mask |= bit;
        self.value |= if demand.is_met(true) { bit } else { 0 };
        self.flip |= if demand.changes() { bit } else { 0 };
    }
}

impl Block {
    fn new(first: usize, transitions: usize) -> Self {
        Self {
            marks: 0,
            todo: !0 >> (BITS - transitions),
            fresh: !0,
            on_shared: 0,
            first,
            end: first + transitions,
        }
    }
}

/// The bits of the places are their numbers.
fn one_word(structure: &Structure) -> (Layout, State) {
    let mut now = Block::new(0, structure.transition_count());
    for (place, &is_marked) in structure.marked.iter().enumerate() {
        now.marks |= u64::from(is_marked) << place;
    }
    let mut users = [[0; 2]; BITS];
    let mut rows = Vec::with_capacity(structure.transition_count() + 1);
    for (lane, arcs) in structure.arcs().enumerate() {
        rows.push(if arcs.has_self_loop {
            row_with_loop(arcs, lane, &mut users)
        } else {
            let (inputs, outputs) = arcs.places.split_at(arcs.inputs);
            let value = word_of(inputs, lane, &mut users, 1);
            let mask = value | word_of(outputs, lane, &mut users, 0);
            Row {
                mask,
                value,
                flip: mask,
                wakes: 0,
            }
        });
    }
    for (lane, row) in rows.iter_mut().enumerate() {
        // One that changes nothing stays enabled.
        row.wakes = u64::from(row.flip == 0) << lane;
        let (mut emptied, mut filled) = (row.flip & row.value, row.flip & !row.value);
        while let Some(bit) = lowest(emptied) {
            row.wakes |= users[bit % BITS][0];
            emptied &= emptied - 1;
        }
        while let Some(bit) = lowest(filled) {
            row.wakes |= users[bit % BITS][1];
            filled &= filled - 1;
        }
    }
    rows.push(Row::NEVER);
    let layout = Layout {
        rows: rows.into(),
        pairs: Box::default(),
        spots: Box::default(),
        users: users[..structure.place_count()].into(),
        has_ports: false,
        ports_of: Box::default(),
        port_changes: Box::default(),
    };
    (layout, State::new(now, Box::default(), 0))
}

/// The word of these places, of which the transition `lane` is a user.
#[inline(always)]
fn word_of(places: &[PlaceId], lane: usize, users: &mut [[u64; 2]; BITS], marked: usize) -> u64 {
    let mut word = 0;
    for place in places {
        let bit = place.index() % BITS;
        word |= 1 << bit;
        users[bit][marked] |= 1 << lane;
    }
    word
}

#[cold]
fn row_with_loop(arcs: Arcs<'_>, lane: usize, users: &mut [[u64; 2]; BITS]) -> Row {
    let mut row = Row::default();
    for_conditions(arcs, |place, demand| {
        let bit = place.index() % BITS;
        row.add(1 << bit, demand);
        users[bit][usize::from(demand.is_met(true))] |= 1 << lane;
    });
    row
}

fn several_words(structure: &Structure, cuts: &Cuts) -> (Layout, State) {
    let count = cuts.blocks.len();
    let transitions = structure.transition_count();
    let mut blocks: Box<[Block]> = { cuts.blocks.iter() }
        .map(|block| Block::new(block.start, block.len()))
        .collect();
    let mut shared_marks = 0;
    for (spot, &is_marked) in cuts.spots.iter().zip(&structure.marked) {
        let marks = match spot.is_shared() {
            true => &mut shared_marks,
            false => &mut blocks[usize::from(spot.block)].marks,
        };
        *marks |= if is_marked { spot.mask() } else { 0 };
    }
    let mut users = vec![[0; 2]; structure.place_count()];
    // By bit of the shared word and block: the users of the place there.
    let mut users_in = vec![[0; 2]; BITS * count];
    let nothing = Pair {
        own: Row::default(),
        shared: Row::default(),
    };
    let mut pairs = vec![nothing; transitions + 1];
    pairs[transitions].own = Row::NEVER;
    for (number, block) in cuts.blocks.iter().enumerate() {
        for transition in block.clone() {
            let lane = 1 << (transition - block.start);
            for_arcs(structure.arcs_of(transition), |place, demand| {
                let spot = cuts.spots[place.index()];
                let when = usize::from(demand.is_met(true));
                if spot.is_shared() {
                    pairs[transition].shared.add(spot.mask(), demand);
                    users[place.index()][when] |= 1 << number;
                    users_in[usize::from(spot.bit) * count + number][when] |= lane;
                    blocks[number].on_shared |= lane;
                } else {
                    pairs[transition].own.add(spot.mask(), demand);
                    users[place.index()][when] |= lane;
                }
            });
        }
    }
    for (number, block) in cuts.blocks.iter().enumerate() {
        for transition in block.clone() {
            let Pair {
                own: row,
                shared: other,
            } = &mut pairs[transition];
            if row.flip | other.flip == 0 {
                row.wakes = 1 << (transition - block.start);
            }
            for_arcs(structure.arcs_of(transition), |place, demand| {
                if !demand.changes() {
                    return;
                }
                let spot = cuts.spots[place.index()];
                let when = usize::from(!demand.is_met(true));
                let wakes = users[place.index()][when];
                if spot.is_shared() {
                    other.wakes |= wakes & !(1 << number);
                    row.wakes |= users_in[usize::from(spot.bit) * count + number][when];
                } else {
                    row.wakes |= wakes;
                }
            });
        }
    }
    let (rows, pairs) = match cuts.spots.iter().any(|spot| spot.is_shared()) {
        true => (Box::default(), pairs.into()),
        false => (pairs.iter().map(|pair| pair.own).collect(), Box::default()),
    };
    let layout = Layout {
        rows,
        pairs,
        spots: cuts.spots.clone().into(),
        users: users.into(),
        has_ports: false,
        ports_of: Box::default(),
        port_changes: Box::default(),
    };
    let first = blocks[0];
    (layout, State::new(first, blocks, shared_marks))
}

/// Adds which sources and sinks each transition changes, in the order of its arcs.
fn add_ports(
    structure: &Structure,
    [sources, sinks]: [&[(PlaceId, EventId)]; 2],
    layout: &mut Layout,
) {
    let index_of = |ports: &[(PlaceId, EventId)], place| {
        ports.partition_point(|&(other, _)| other < place) as u16
    };
    let mut changes = Vec::new();
    let mut spans = vec![Span::default(); structure.transition_count()];
    for (arcs, of) in structure.arcs().zip(&mut spans) {
        let start = changes.len();
        for_arcs(arcs, |place, demand| match structure.kind(place) {
            PlaceKind::Source if demand.changes() => {
                changes.push(PortChange::SourceEmptied(index_of(sources, place)));
            }
            PlaceKind::Sink => changes.push(PortChange::SinkFilled(index_of(sinks, place))),
            _ => {}
        });
        *of = span(start, changes.len());
    }
    layout.has_ports = true;
    layout.ports_of = spans.into();
    layout.port_changes = changes.into();
}
