//! From a checked model to masks; see [masks](super).

use alloc::boxed::Box;
use alloc::vec;
use alloc::vec::Vec;

use super::cuts::Cuts;
use super::layout::{BITS, Layout, Pair, Row, Spot};
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
            several_words(structure, Cuts::of(structure)?)
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

/// By bit of a word: the transitions of a block that need the place empty, and those that need it marked.
type Users = [[u64; 2]; BITS];

/// Those that may be enabled when `row` has fired.
#[inline(always)]
fn woken(row: &Row, users: &Users) -> u64 {
    let mut woken = 0;
    let (mut emptied, mut filled) = (row.flip & row.value, row.flip & !row.value);
    while let Some(bit) = lowest(emptied) {
        woken |= users[bit % BITS][0];
        emptied &= emptied - 1;
    }
    while let Some(bit) = lowest(filled) {
        woken |= users[bit % BITS][1];
        filled &= filled - 1;
    }
    woken
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
        let mut row = Row::default();
        if arcs.has_self_loop {
            for_conditions(arcs, |place, demand| {
                row.add(1 << (place.index() % BITS), demand);
                users[place.index() % BITS][usize::from(demand.is_met(true))] |= 1 << lane;
            });
        } else {
            let (inputs, outputs) = arcs.places.split_at(arcs.inputs);
            for place in inputs {
                row.value |= 1 << (place.index() % BITS);
                users[place.index() % BITS][1] |= 1 << lane;
            }
            row.mask = row.value;
            for place in outputs {
                row.mask |= 1 << (place.index() % BITS);
                users[place.index() % BITS][0] |= 1 << lane;
            }
            row.flip = row.mask;
        }
        rows.push(row);
    }
    for (lane, row) in rows.iter_mut().enumerate() {
        // One that changes nothing stays enabled.
        row.wakes = u64::from(row.flip == 0) << lane | woken(row, &users);
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

fn several_words(structure: &Structure, cuts: Cuts) -> (Layout, State) {
    let Cuts { blocks, spots } = cuts;
    let mut states: Box<[Block]> = { blocks.iter() }
        .map(|block| Block::new(block.start, block.len()))
        .collect();
    let mut shared_marks = 0;
    for (spot, &is_marked) in spots.iter().zip(&structure.marked) {
        let marks = match spot.is_shared() {
            true => &mut shared_marks,
            false => &mut states[usize::from(spot.block)].marks,
        };
        *marks |= u64::from(is_marked) << spot.bit;
    }
    let mut pairs: Vec<Pair> = Vec::with_capacity(structure.transition_count() + 1);
    // By block, of its own word.
    let mut users_of = vec![[[0; 2]; BITS]; blocks.len()];
    // By bit of the shared word: the blocks that need the place empty or marked.
    let mut blocks_of: Users = [[0; 2]; BITS];
    let mut all = structure.arcs();
    for ((number, state), own_users) in states.iter_mut().enumerate().zip(&mut users_of) {
        // Of the block's own word, and of the shared one.
        let mut users: [Users; 2] = [[[0; 2]; BITS]; 2];
        for (lane, arcs) in all.by_ref().take(state.end - state.first).enumerate() {
            let mut pair = Pair::default();
            if arcs.has_self_loop {
                for_conditions(arcs, |place, demand| {
                    let when = usize::from(demand.is_met(true));
                    let [own, shared] = words_of(&[place], &spots, lane, when, &mut users);
                    pair.own.add(own, demand);
                    pair.shared.add(shared, demand);
                });
            } else {
                let (inputs, outputs) = arcs.places.split_at(arcs.inputs);
                let [own, shared] = words_of(inputs, &spots, lane, 1, &mut users);
                (pair.own.value, pair.shared.value) = (own, shared);
                let [more, further] = words_of(outputs, &spots, lane, 0, &mut users);
                (pair.own.mask, pair.shared.mask) = (own | more, shared | further);
                (pair.own.flip, pair.shared.flip) = (pair.own.mask, pair.shared.mask);
            }
            pairs.push(pair);
        }
        for (lane, Pair { own, shared }) in pairs[state.first..].iter_mut().enumerate() {
            own.wakes = woken(own, &users[0]) | woken(shared, &users[1]);
            own.wakes |= u64::from(own.flip | shared.flip == 0) << lane;
            state.on_shared |= u64::from(shared.mask != 0) << lane;
        }
        let shared_users;
        [*own_users, shared_users] = users;
        for (blocks, users) in blocks_of.iter_mut().zip(&shared_users) {
            for (blocks, users) in blocks.iter_mut().zip(users) {
                *blocks |= u64::from(*users != 0) << number;
            }
        }
    }
    for (number, state) in states.iter().enumerate() {
        for Pair { shared, .. } in &mut pairs[state.first..state.end] {
            shared.wakes = woken(shared, &blocks_of) & !(1 << number);
        }
    }
    let users = spots.iter().map(|spot| match spot.is_shared() {
        true => blocks_of[usize::from(spot.bit)],
        false => users_of[usize::from(spot.block)][usize::from(spot.bit)],
    });
    let users = users.collect();
    pairs.push(Pair {
        own: Row::NEVER,
        shared: Row::default(),
    });
    let (rows, pairs) = match blocks_of.iter().any(|blocks| blocks[0] | blocks[1] != 0) {
        true => (Box::default(), pairs.into()),
        false => (pairs.iter().map(|pair| pair.own).collect(), Box::default()),
    };
    let layout = Layout {
        rows,
        pairs,
        spots: spots.into(),
        users,
        has_ports: false,
        ports_of: Box::default(),
        port_changes: Box::default(),
    };
    let first = states[0];
    (layout, State::new(first, states, shared_marks))
}

/// The words of these places, own and shared, of which the transition `lane` is a user that needs them
/// empty or marked.
#[inline(always)]
fn words_of(
    places: &[PlaceId],
    spots: &[Spot],
    lane: usize,
    when: usize,
    users: &mut [Users; 2],
) -> [u64; 2] {
    let (mut own, mut shared) = (0, 0);
    for place in places {
        let spot = spots[place.index()];
        own |= if spot.is_shared() { 0 } else { spot.mask() };
        shared |= if spot.is_shared() { spot.mask() } else { 0 };
        let users = &mut users[usize::from(spot.is_shared())];
        users[usize::from(spot.bit) % BITS][when] |= 1 << lane;
    }
    [own, shared]
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
