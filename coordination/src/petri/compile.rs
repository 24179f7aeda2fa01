//! Lays a net out; see [the layout](super::layout).

use super::conditions::{Condition, for_conditions, places};
use super::layout::{
    BLOCK, Bits, Block, Effects, Flip, Gate, Layout, Need, Place, PortChange, SLOTS, Span, Special,
    WordBits,
};
use super::model::PlaceKind;
use super::net::{PlaceId, TransitionId};
use super::state::State;
use super::structure::Structure;
use crate::event::EventId;

/// The tables of `structure`, and its state with all places empty. `sources` and `sinks` are in the
/// order of their places.
pub(super) fn compile(
    structure: &Structure,
    sources: &[(PlaceId, EventId)],
    sinks: &[(PlaceId, EventId)],
) -> (Layout, State) {
    let mut tables = Tables::new(structure);
    for transition in structure.transitions() {
        tables.add_conditions(structure, transition);
    }
    let mut firings = Firings::new(tables, sources, sinks);
    for transition in structure.transitions() {
        firings.add(structure, transition);
    }
    firings.finish(structure)
}

/// Where each condition is.
struct Tables {
    /// With all places empty.
    blocks: Vec<Block>,
    places: Vec<Place>,
    flips: Vec<Flip>,
    gates_of: Vec<Span>,
    gates: Vec<Gate>,
    /// By shared place: the blocks that mention it.
    users: Vec<Vec<WordBits>>,
}

impl Tables {
    fn new(structure: &Structure) -> Self {
        let transitions = structure.transition_count();
        let (places, shared) = places(structure);
        let last = places.last().expect("a transition has inputs");
        let no_flip = Flip {
            block: u32::MAX,
            bits: [0; SLOTS],
        };
        let block = Block {
            conditions: [!0; SLOTS],
            fresh: !0,
            special: 0,
            several: 0,
        };
        let block_count = transitions.div_ceil(BLOCK);
        let mut blocks = vec![block; block_count];
        blocks[block_count - 1].conditions[0] = !0 >> (block_count * BLOCK - transitions);
        Self {
            blocks,
            flips: vec![no_flip; (last.first_flip + last.flips) as usize],
            places,
            gates_of: vec![Span::default(); block_count],
            gates: Vec::new(),
            users: vec![Vec::new(); shared],
        }
    }

    fn add_conditions(&mut self, structure: &Structure, transition: TransitionId) {
        let (block, lane) = (transition.index() / BLOCK, transition.index() % BLOCK);
        if lane == 0 {
            self.gates_of[block] = span(self.gates.len(), self.gates.len());
        }
        let mut slot = 0;
        let mut shared_count = 0;
        let mut last_shared = None;
        for_conditions(structure, transition, |condition| {
            let place = &mut self.places[condition.place];
            if place.is_shared() {
                let blocks = &mut self.users[place.shared as usize];
                add_number(blocks, block as u32);
                last_shared = Some(condition);
                shared_count += 1;
                return;
            }
            if condition.when_marked {
                self.blocks[block].conditions[slot] &= !(1 << lane);
            }
            let flips = &mut self.flips[place.first_flip as usize..][..place.flips as usize];
            let flip = flips
                .iter_mut()
                .find(|flip| flip.block == block as u32 || flip.block == u32::MAX)
                .expect("a place has flips for every block that mentions it");
            flip.block = block as u32;
            flip.bits[slot] |= 1 << lane;
            place.transition = transition.index() as u32;
            place.slot = slot as u8;
            place.when_marked = condition.when_marked;
            slot += 1;
        });
        match last_shared {
            Some(condition) if shared_count == 1 => self.add_to_gate(block, lane, condition),
            Some(_) => self.blocks[block].several |= 1 << lane,
            None => {}
        }
        self.gates_of[block].end = self.gates.len() as u32;
    }

    fn add_to_gate(&mut self, block: usize, lane: usize, condition: Condition) {
        let shared = self.places[condition.place].shared;
        let first = self.gates_of[block].start as usize;
        let known = self.gates[first..].iter_mut();
        let gate = match { known }.position(|gate| gate.shared == shared) {
            Some(index) => &mut self.gates[first + index],
            None => {
                self.gates.push(Gate {
                    shared,
                    when_marked: 0,
                    when_empty: 0,
                });
                self.gates.last_mut().expect("one was just added")
            }
        };
        let bits = if condition.when_marked {
            &mut gate.when_marked
        } else {
            &mut gate.when_empty
        };
        *bits |= 1 << lane;
    }
}

/// What each firing does.
struct Firings<'a> {
    tables: Tables,
    sources: &'a [(PlaceId, EventId)],
    sinks: &'a [(PlaceId, EventId)],
    own: Vec<[Bits; BLOCK]>,
    specials: Vec<Special>,
    effects: Vec<Effects>,
    needs: Vec<Need>,
    far: Vec<Flip>,
    ports: Vec<PortChange>,
    word_bits: Vec<WordBits>,
    /// By shared place: index of its gate in the block at hand, if that is a gate of this place.
    gate_of: Vec<u32>,
    // Of the transition at hand:
    marks: Vec<WordBits>,
    wakes: Vec<WordBits>,
}

impl<'a> Firings<'a> {
    fn new(
        tables: Tables,
        sources: &'a [(PlaceId, EventId)],
        sinks: &'a [(PlaceId, EventId)],
    ) -> Self {
        Self {
            own: vec![[[0; SLOTS]; BLOCK]; tables.blocks.len()],
            gate_of: vec![0; tables.users.len()],
            tables,
            sources,
            sinks,
            specials: Vec::new(),
            effects: Vec::new(),
            needs: Vec::new(),
            far: Vec::new(),
            ports: Vec::new(),
            word_bits: Vec::new(),
            marks: Vec::new(),
            wakes: Vec::new(),
        }
    }

    fn add(&mut self, structure: &Structure, transition: TransitionId) {
        let (block, lane) = (transition.index() / BLOCK, transition.index() % BLOCK);
        let Tables {
            blocks,
            places,
            flips,
            gates_of,
            gates,
            users,
        } = &mut self.tables;
        let here = gates_of[block];
        if lane == 0 {
            for index in here.start..here.end {
                self.gate_of[gates[index as usize].shared as usize] = index;
            }
        }
        let before = (self.far.len(), self.ports.len());
        self.marks.clear();
        self.wakes.clear();
        let mut own = [0; SLOTS];
        let mut open = 0;
        for_conditions(structure, transition, |condition| {
            if !condition.changes {
                return;
            }
            let place = &places[condition.place];
            if place.is_shared() {
                add_number(&mut self.marks, place.shared);
                for &blocks in &users[place.shared as usize] {
                    merge_bits(&mut self.wakes, blocks);
                }
                let gate = self.gate_of[place.shared as usize];
                if (here.start..here.end).contains(&gate) {
                    let gate = &gates[gate as usize];
                    if gate.shared == place.shared {
                        open |= gate.when_marked | gate.when_empty;
                    }
                }
            }
            let first = place.first_flip as usize;
            for flip in &flips[first..first + place.flips as usize] {
                if flip.block as usize == block {
                    flip_bits(&mut own, &flip.bits);
                    continue;
                }
                let mut known = self.far[before.0..].iter_mut();
                match known.find(|known| known.block == flip.block) {
                    Some(known) => flip_bits(&mut known.bits, &flip.bits),
                    None => self.far.push(*flip),
                }
            }
            let place = PlaceId::from_index(condition.place);
            let index_of = |ports: &[(PlaceId, EventId)]| {
                ports.partition_point(|&(other, _)| other < place) as u16
            };
            match structure.kind(place) {
                PlaceKind::Internal => {}
                PlaceKind::Source => {
                    let change = PortChange::SourceEmptied(index_of(self.sources));
                    self.ports.push(change);
                }
                PlaceKind::Sink => {
                    let change = PortChange::SinkFilled(index_of(self.sinks));
                    self.ports.push(change);
                }
            }
        });
        self.own[block][lane] = own;
        let several = blocks[block].several >> lane & 1 == 1;
        let effects = before != (self.far.len(), self.ports.len());
        if !effects && self.marks.is_empty() && !several {
            return;
        }
        blocks[block].special |= 1 << lane;
        let mut special = Special {
            open,
            marks: self.marks.pop().unwrap_or_default(),
            wakes: self.wakes.pop().unwrap_or_default(),
            ..Special::NOTHING
        };
        if effects || !self.marks.is_empty() || !self.wakes.is_empty() {
            special.more = self.effects.len() as u32;
            self.effects.push(Effects {
                far: span(before.0, self.far.len()),
                ports: span(before.1, self.ports.len()),
                marks: append(&mut self.word_bits, &mut self.marks),
                wakes: append(&mut self.word_bits, &mut self.wakes),
            });
        }
        if several {
            special.needs = self.needs_of(structure, transition);
        }
        self.specials.resize(transition.index(), Special::NOTHING);
        self.specials.push(special);
    }

    /// What a transition needs of several shared places.
    fn needs_of(&mut self, structure: &Structure, transition: TransitionId) -> Span {
        let mut conditions = Vec::new();
        for_conditions(structure, transition, |condition| {
            let place = &self.tables.places[condition.place];
            if place.is_shared() {
                conditions.push((place.shared, condition.when_marked));
            }
        });
        conditions.sort_unstable();
        let start = self.needs.len();
        for (shared, when_marked) in conditions {
            let (word, bit) = (shared / u64::BITS, 1 << (shared % u64::BITS));
            if self.needs[start..]
                .last()
                .is_none_or(|last| last.word != word)
            {
                self.needs.push(Need {
                    word,
                    care: 0,
                    value: 0,
                });
            }
            if let Some(need) = self.needs.last_mut() {
                need.care |= bit;
                need.value |= if when_marked { bit } else { 0 };
            }
        }
        span(start, self.needs.len())
    }

    fn finish(mut self, structure: &Structure) -> (Layout, State) {
        let tables = self.tables;
        let users = tables.users.iter();
        let wakes_of = users.map(|users| append(&mut self.word_bits, &mut users.clone()));
        let wakes_of: Vec<_> = wakes_of.collect();
        let marks = tables.users.len().div_ceil(u64::BITS as usize);
        let layout = Layout {
            transitions: structure.transition_count(),
            own: self.own.into(),
            specials: self.specials.into(),
            effects: self.effects.into(),
            needs: self.needs.into(),
            far: self.far.into(),
            port_changes: self.ports.into(),
            word_bits: self.word_bits.into(),
            gates_of: tables.gates_of.into(),
            gates: tables.gates.into(),
            places: tables.places.into(),
            flips: tables.flips.into(),
            wakes_of: wakes_of.into(),
        };
        let state = State::new(&layout, tables.blocks.into(), marks);
        (layout, state)
    }
}

fn flip_bits(bits: &mut Bits, flips: &Bits) {
    for (bits, flips) in bits.iter_mut().zip(flips) {
        *bits ^= flips;
    }
}

/// Adds a number to a set.
fn add_number(set: &mut Vec<WordBits>, number: u32) {
    merge_bits(
        set,
        WordBits {
            word: number / u64::BITS,
            bits: 1 << (number % u64::BITS),
        },
    );
}

fn merge_bits(set: &mut Vec<WordBits>, more: WordBits) {
    match set.iter_mut().rev().find(|known| known.word == more.word) {
        Some(known) => known.bits |= more.bits,
        None => set.push(more),
    }
}

fn append<T>(all: &mut Vec<T>, list: &mut Vec<T>) -> Span {
    let start = all.len();
    all.append(list);
    span(start, all.len())
}

fn span(start: usize, end: usize) -> Span {
    Span {
        start: start as u32,
        end: end as u32,
    }
}
