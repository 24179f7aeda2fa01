//! From a checked model to masks; see [masks](super).

use alloc::boxed::Box;
use alloc::vec;
use alloc::vec::Vec;

use super::cuts::Cuts;
use super::layout::{BITS, Layout, Row, Users};
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
        spots: Box::default(),
        users: Box::default(),
        shared: 0,
        neighbours: Box::default(),
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

/// Adds what a transition, the one of this lane, asks and does, place by place; `bit_of` says where each is.
#[inline(always)]
fn row_of(
    arcs: Arcs<'_>,
    lane: usize,
    users: &mut Users,
    bit_of: impl Fn(PlaceId) -> usize,
) -> Row {
    let mut row = Row::default();
    if arcs.has_self_loop {
        for_conditions(arcs, |place, demand| {
            let bit = bit_of(place) % BITS;
            row.add(1 << bit, demand);
            users[bit][usize::from(demand.is_met(true))] |= 1 << lane;
        });
        return row;
    }
    let (inputs, outputs) = arcs.places.split_at(arcs.inputs);
    for &place in inputs {
        let bit = bit_of(place) % BITS;
        row.value |= 1 << bit;
        users[bit][1] |= 1 << lane;
    }
    row.mask = row.value;
    for &place in outputs {
        let bit = bit_of(place) % BITS;
        row.mask |= 1 << bit;
        users[bit][0] |= 1 << lane;
    }
    row.flip = row.mask;
    row
}

/// Adds which transitions of the block the firings of its rows may enable.
#[inline(always)]
fn add_wakes(rows: &mut [Row], users: &Users) {
    for (lane, row) in rows.iter_mut().enumerate() {
        // One that changes nothing stays enabled.
        row.wakes = u64::from(row.flip == 0) << lane | woken(row, users);
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
        rows.push(row_of(arcs, lane, &mut users, PlaceId::index));
    }
    add_wakes(&mut rows, &users);
    rows.push(Row::NEVER);
    let layout = Layout {
        rows: rows.into(),
        spots: Box::default(),
        users: [users].into(),
        shared: 0,
        neighbours: Box::default(),
        has_ports: false,
        ports_of: Box::default(),
        port_changes: Box::default(),
    };
    (layout, State::new(now, Box::default(), 0))
}

fn several_words(structure: &Structure, cuts: Cuts) -> (Layout, State) {
    let Cuts {
        blocks,
        spots,
        shared,
    } = cuts;
    let mut states: Box<[Block]> = { blocks.iter() }
        .map(|block| Block::new(block.start, block.len()))
        .collect();
    let last = states.len() - 1;
    for (spot, &is_marked) in spots.iter().zip(&structure.marked) {
        // Shared ones in the block that runs first.
        let block = usize::from(spot.block).min(last);
        states[block].marks |= u64::from(is_marked) << spot.bit;
    }
    let mut rows: Vec<Row> = Vec::with_capacity(structure.transition_count() + 1);
    let mut users: Vec<Users> = vec![[[0; 2]; BITS]; blocks.len()];
    let mut neighbours = vec![[0; 2]; shared.count_ones() as usize];
    let mut all = structure.arcs();
    for ((number, state), users) in states.iter_mut().enumerate().zip(&mut users) {
        for (lane, arcs) in all.by_ref().take(state.end - state.first).enumerate() {
            let row = row_of(arcs, lane, users, |place| spots[place.index()].bit.into());
            state.on_shared |= u64::from(row.mask & shared != 0) << lane;
            rows.push(row);
        }
        add_wakes(&mut rows[state.first..], users);
        for (blocks, users) in neighbours.iter_mut().zip(users.iter().rev()) {
            for (blocks, users) in blocks.iter_mut().zip(users) {
                *blocks |= u64::from(*users != 0) << number;
            }
        }
    }
    rows.push(Row::NEVER);
    let layout = Layout {
        rows: rows.into(),
        spots: spots.into(),
        users: users.into(),
        shared,
        neighbours: neighbours.into(),
        has_ports: false,
        ports_of: Box::default(),
        port_changes: Box::default(),
    };
    let first = states[0];
    (layout, State::new(first, states, shared))
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
