//! Lays a net out; see [the layout](super::layout).

use super::conditions::{Condition, Conditions, places};
use super::layout::{
    BLOCK, Bits, Block, Effects, Flip, Gate, Layout, Need, Place, PortChange, SLOTS, Span, Special,
    Witness, WordBits,
};
use super::model::PlaceKind;
use super::net::PlaceId;
use super::state::State;
use super::structure::Structure;
use crate::event::EventId;

/// The tables of `structure`, and its state in the initial marking. `sources` and `sinks` are in the
/// order of their places.
pub(super) fn compile(
    structure: &Structure,
    sources: &[(PlaceId, EventId)],
    sinks: &[(PlaceId, EventId)],
) -> (Layout, State) {
    let conditions = Conditions::new(structure);
    let mut tables = Tables::new(&conditions, structure.place_count());
    for transition in 0..conditions.transitions() {
        tables.add_conditions(transition, conditions.of(transition));
    }
    let mut firings = Firings::new(tables, structure, sources, sinks);
    for transition in 0..conditions.transitions() {
        firings.add(transition, conditions.of(transition));
    }
    firings.finish()
}

/// Where each condition is.
struct Tables {
    /// With all places empty.
    blocks: Vec<Block>,
    places: Vec<Place>,
    flips: Vec<Flip>,
    gates_of: Vec<Span>,
    gates: Vec<Gate>,
    shared: usize,
    /// By shared place: the set of the blocks that mention it.
    users: Vec<u64>,
}

/// Words of a set of blocks.
fn set_words(blocks: usize) -> usize {
    blocks.div_ceil(BLOCK)
}

impl Tables {
    fn new(conditions: &Conditions, place_count: usize) -> Self {
        let transitions = conditions.transitions();
        let (places, flips, shared) = places(conditions, place_count);
        let no_flip = Flip {
            block: 0,
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
            places,
            flips: vec![no_flip; flips],
            gates_of: vec![Span::default(); block_count],
            gates: Vec::new(),
            shared,
            users: vec![0; shared * set_words(block_count)],
        }
    }

    fn add_conditions(&mut self, transition: usize, conditions: &[Condition]) {
        let (block, lane) = (transition / BLOCK, transition % BLOCK);
        if lane == 0 {
            self.gates_of[block] = span(self.gates.len(), self.gates.len());
        }
        let mut slot = 0;
        let mut last_shared = None;
        for &condition in conditions {
            let place = &mut self.places[condition.place()];
            if place.is_shared() {
                let words = set_words(self.blocks.len());
                let word = place.index as usize * words + block / BLOCK;
                self.users[word] |= 1 << (block % BLOCK);
                last_shared = Some(condition);
                continue;
            }
            if condition.when_marked() {
                self.blocks[block].conditions[slot] &= !(1 << lane);
            }
            // Transitions come in order: if the place has a flip in this block, it is the last.
            let last = (place.index + place.flips) as usize;
            let flip = if place.flips > 0 && self.flips[last - 1].block == block as u32 {
                &mut self.flips[last - 1]
            } else {
                place.flips += 1;
                &mut self.flips[last]
            };
            flip.block = block as u32;
            flip.bits[slot] |= 1 << lane;
            place.witness = Witness {
                transition: transition as u16,
                slot: slot as u8,
                when_marked: condition.when_marked(),
            };
            slot += 1;
        }
        if let Some(condition) = last_shared {
            if conditions.len() - slot == 1 {
                self.add_to_gate(block, lane, condition);
            } else {
                self.blocks[block].several |= 1 << lane;
            }
        }
    }

    fn add_to_gate(&mut self, block: usize, lane: usize, condition: Condition) {
        let shared = self.places[condition.place()].index;
        let first = self.gates_of[block].start as usize;
        let known = self.gates[first..]
            .iter()
            .position(|gate| gate.shared == shared);
        let index = known.map_or(self.gates.len(), |index| first + index);
        if known.is_none() {
            self.gates.push(Gate {
                shared,
                when_marked: 0,
                when_empty: 0,
            });
            self.gates_of[block].end = self.gates.len() as u32;
        }
        let gate = &mut self.gates[index];
        let bits = if condition.when_marked() {
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
    structure: &'a Structure,
    sources: &'a [(PlaceId, EventId)],
    sinks: &'a [(PlaceId, EventId)],
    own: Vec<[Bits; BLOCK]>,
    specials: Vec<Special>,
    effects: Vec<Effects>,
    needs: Vec<Need>,
    far: Vec<Flip>,
    ports: Vec<PortChange>,
    word_bits: Vec<WordBits>,
    /// By shared place: index of its gate in the block at hand, if that is in the block's span.
    gate_of: Vec<u32>,
    // Of the transition at hand:
    marks: Vec<WordBits>,
    wakes: Vec<WordBits>,
    needed: Vec<(u32, bool)>,
}

impl<'a> Firings<'a> {
    fn new(
        tables: Tables,
        structure: &'a Structure,
        sources: &'a [(PlaceId, EventId)],
        sinks: &'a [(PlaceId, EventId)],
    ) -> Self {
        Self {
            own: vec![[[0; SLOTS]; BLOCK]; tables.blocks.len()],
            gate_of: vec![u32::MAX; tables.shared],
            tables,
            structure,
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
            needed: Vec::new(),
        }
    }

    fn add(&mut self, transition: usize, conditions: &[Condition]) {
        let (block, lane) = (transition / BLOCK, transition % BLOCK);
        if lane == 0 {
            let span = self.tables.gates_of[block];
            for (gate, index) in span.of(&self.tables.gates).iter().zip(span.start..) {
                self.gate_of[gate.shared as usize] = index;
            }
        }
        let (first_far, first_port) = (self.far.len(), self.ports.len());
        let mut own = [0; SLOTS];
        let mut open = 0;
        for condition in conditions.iter().filter(|condition| condition.changes()) {
            let place = &self.tables.places[condition.place()];
            if place.is_shared() {
                let shared = place.index;
                open |= self.gated_by(block, shared);
                self.change_shared(shared);
                continue;
            }
            for flip in place.flips(&self.tables.flips) {
                if flip.block as usize == block {
                    flip_bits(&mut own, &flip.bits);
                } else {
                    add_flip(&mut self.far, first_far, flip);
                }
            }
        }
        self.own[block][lane] = own;
        if !self.sources.is_empty() || !self.sinks.is_empty() {
            self.add_ports(conditions);
        }
        let far = span(first_far, self.far.len());
        let ports = span(first_port, self.ports.len());
        let several = self.tables.blocks[block].several >> lane & 1 == 1;
        if far.is_empty() && ports.is_empty() && self.marks.is_empty() && !several {
            return;
        }
        let mut special = Special {
            open,
            marks: self.marks.pop().unwrap_or_default(),
            wakes: self.wakes.pop().unwrap_or_default(),
            ..Special::NOTHING
        };
        let more = !self.marks.is_empty() || !self.wakes.is_empty();
        if more || !far.is_empty() || !ports.is_empty() {
            special.more = self.effects.len() as u32;
            self.effects.push(Effects {
                far,
                ports,
                marks: append(&mut self.word_bits, &mut self.marks),
                wakes: append(&mut self.word_bits, &mut self.wakes),
            });
        }
        if several {
            special.needs = self.add_needs(conditions);
        }
        self.tables.blocks[block].special |= 1 << lane;
        self.specials.resize(transition, Special::NOTHING);
        self.specials.push(special);
    }

    /// The transitions of a block for which this is the one shared place.
    fn gated_by(&self, block: usize, shared: u32) -> u64 {
        let index = self.gate_of[shared as usize];
        let gates = self.tables.gates_of[block];
        if index < gates.start || index >= gates.end {
            return 0;
        }
        let gate = &self.tables.gates[index as usize];
        gate.when_marked | gate.when_empty
    }

    /// The transition at hand changes a shared place.
    fn change_shared(&mut self, shared: u32) {
        let (word, bits) = (shared / u64::BITS, 1 << (shared % u64::BITS));
        merge(&mut self.marks, WordBits { word, bits });
        let words = set_words(self.tables.blocks.len());
        let users = &self.tables.users[shared as usize * words..][..words];
        for (&bits, word) in users.iter().zip(0..) {
            if bits != 0 {
                merge(&mut self.wakes, WordBits { word, bits });
            }
        }
    }

    fn add_ports(&mut self, conditions: &[Condition]) {
        for condition in conditions.iter().filter(|condition| condition.changes()) {
            let place = PlaceId::from_index(condition.place());
            let index_of = |ports: &[(PlaceId, EventId)]| {
                ports.partition_point(|&(other, _)| other < place) as u16
            };
            self.ports.extend(match self.structure.kind(place) {
                PlaceKind::Internal => None,
                PlaceKind::Source => Some(PortChange::SourceEmptied(index_of(self.sources))),
                PlaceKind::Sink => Some(PortChange::SinkFilled(index_of(self.sinks))),
            });
        }
    }

    /// What a transition needs of several shared places.
    fn add_needs(&mut self, conditions: &[Condition]) -> Span {
        self.needed.clear();
        for condition in conditions {
            let place = &self.tables.places[condition.place()];
            if place.is_shared() {
                self.needed.push((place.index, condition.when_marked()));
            }
        }
        self.needed.sort_unstable();
        let start = self.needs.len();
        for &(shared, when_marked) in &self.needed {
            let (word, bit) = (shared / u64::BITS, 1 << (shared % u64::BITS));
            let last = self.needs[start..].last();
            if last.is_none_or(|last| last.word != word) {
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

    fn finish(self) -> (Layout, State) {
        let tables = self.tables;
        let layout = Layout {
            transitions: self.structure.transition_count(),
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
            users: tables.users.into(),
        };
        let marked = self.structure.places();
        let marked = marked.filter(|&place| self.structure.marked(place));
        let state = State::new(&layout, tables.blocks.into(), tables.shared, marked);
        (layout, state)
    }
}

fn flip_bits(bits: &mut Bits, flips: &Bits) {
    for (bits, flips) in bits.iter_mut().zip(flips) {
        *bits ^= flips;
    }
}

/// Combines a flip with those from `first` on.
fn add_flip(flips: &mut Vec<Flip>, first: usize, more: &Flip) {
    let mut known = flips[first..].iter_mut();
    match known.find(|flip| flip.block == more.block) {
        Some(flip) => flip_bits(&mut flip.bits, &more.bits),
        None => flips.push(*more),
    }
}

/// Adds some members to a set.
fn merge(set: &mut Vec<WordBits>, more: WordBits) {
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
