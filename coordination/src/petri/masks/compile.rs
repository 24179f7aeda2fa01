//! From a checked model to masks; see [masks](super).

use alloc::boxed::Box;
use alloc::vec;
use alloc::vec::Vec;
use core::ops::Range;

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
#[inline(always)]
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

/// What the transitions of a block ask and do, and who needs its places how; `bit_of` says where each place is. A function of its own, which
/// has the registers for itself.
#[inline(never)]
fn add_rows(
    structure: &Structure,
    block: Range<usize>,
    rows: &mut [Row],
    users: &mut Users,
    bit_of: impl Fn(PlaceId) -> usize,
) {
    let mut own = 1_u64;
    let self_loops = &structure.self_loops[block.clone()];
    let arcs = structure.arcs_among(block.clone());
    for (((inputs, outputs), row), &has_self_loop) in arcs.zip(&mut *rows).zip(self_loops) {
        if has_self_loop {
            let arcs = structure.arcs_of(block.start + own.trailing_zeros() as usize);
            *row = row_with_self_loops(arcs, own, users, &bit_of);
        } else {
            let (mut value, mut flip) = (0, 0);
            for &place in inputs {
                let bit = bit_of(place) % BITS;
                value |= 1 << bit;
                users[bit][1] |= own;
            }
            for &place in outputs {
                let bit = bit_of(place) % BITS;
                flip |= 1 << bit;
                users[bit][0] |= own;
            }
            flip |= value;
            *row = Row {
                mask: flip,
                value,
                flip,
                wakes: 0,
            };
        }
        own <<= 1;
    }
    for row in rows {
        row.wakes = woken(row, users);
    }
}

#[cold]
fn row_with_self_loops(
    arcs: Arcs<'_>,
    own: u64,
    users: &mut Users,
    bit_of: impl Fn(PlaceId) -> usize,
) -> Row {
    let mut row = Row::default();
    for_conditions(arcs, |place, demand| {
        let bit = bit_of(place) % BITS;
        row.add(1 << bit, demand);
        users[bit][usize::from(demand.is_met(true))] |= own;
    });
    row
}

/// A row for each transition, and the last one.
fn empty_rows(structure: &Structure) -> Box<[Row]> {
    let mut rows = vec![Row::default(); structure.transition_count() + 1];
    rows[structure.transition_count()] = Row::NEVER;
    rows.into()
}

/// The bits of the places are their numbers.
fn one_word(structure: &Structure) -> (Layout, State) {
    let mut now = Block::new(0, structure.transition_count());
    for (place, &is_marked) in structure.marked.iter().enumerate() {
        now.marks |= u64::from(is_marked) << place;
    }
    let mut users: Users = [[0; 2]; BITS];
    let mut rows = empty_rows(structure);
    let all = 0..structure.transition_count();
    add_rows(
        structure,
        all.clone(),
        &mut rows[all],
        &mut users,
        PlaceId::index,
    );
    let users = users[..structure.place_count()].into();
    let layout = Layout {
        rows,
        spots: Box::default(),
        users,
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
        if is_marked {
            // Shared ones in the block that runs first.
            let block = usize::from(spot.block).min(last);
            states[block].marks |= spot.mask();
        }
    }
    let mut rows = empty_rows(structure);
    let mut all_users = vec![[0; 2]; BITS * blocks.len()];
    let mut neighbours = vec![[0; 2]; shared.count_ones() as usize];
    let users = all_users.as_chunks_mut::<BITS>().0;
    for ((number, state), users) in states.iter_mut().enumerate().zip(users) {
        let block = state.first..state.end;
        let rows = &mut rows[block.clone()];
        add_rows(structure, block, rows, users, |place| {
            spots[place.index()].bit.into()
        });
        if shared != 0 {
            for (lane, row) in rows.iter().enumerate() {
                state.on_shared |= u64::from(row.mask & shared != 0) << lane;
            }
        }
        for (blocks, users) in neighbours.iter_mut().zip(users.iter().rev()) {
            for (blocks, users) in blocks.iter_mut().zip(users) {
                *blocks |= u64::from(*users != 0) << number;
            }
        }
    }
    let layout = Layout {
        rows,
        spots: spots.into(),
        users: all_users.into(),
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
