//! Lays a net out; see [the layout](super::layout).

use super::conditions::{for_conditions, places};
use super::layout::{
    BLOCK, Bits, Block, Effects, Flip, Gate, Layout, Need, Place, PortChange, SLOTS, Span, Special,
    Witness, WordBits,
};
use super::model::PlaceKind;
use super::net::PlaceId;
use super::state::State;
use super::structure::{Arcs, Structure};
use crate::event::EventId;

/// The tables of `structure`, and its state in the initial marking. `sources` and `sinks` are in the
/// order of their places.
pub(super) fn compile(
    structure: &Structure,
    sources: &[(PlaceId, EventId)],
    sinks: &[(PlaceId, EventId)],
) -> (Layout, State) {
    let mut tables = Tables::new(structure);
    let mut transitions = structure.arcs();
    for block in 0..tables.blocks.len() {
        tables.add_block(block, transitions.by_ref().take(BLOCK));
    }
    let mut firings = Firings::new(tables, structure, sources, sinks);
    let mut transitions = structure.arcs();
    for block in 0..firings.own.len() {
        firings.add_block(block, transitions.by_ref().take(BLOCK));
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
    fn new(structure: &Structure) -> Self {
        let transitions = structure.transition_count();
        let (places, shared) = places(structure);
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
            flips: Vec::with_capacity(places.len() + places.len() / 4),
            places,
            gates_of: vec![Span::default(); block_count],
            gates: Vec::new(),
            shared,
            users: vec![0; shared * set_words(block_count)],
        }
    }

    fn add_block<'a>(&mut self, block: usize, transitions: impl Iterator<Item = Arcs<'a>>) {
        let words = set_words(self.blocks.len());
        let first_gate = self.gates.len();
        let Block {
            conditions,
            several,
            ..
        } = &mut self.blocks[block];
        for (lane, arcs) in transitions.enumerate() {
            let bit = 1 << lane;
            let mut slot = 0;
            let mut shared_count = 0;
            let mut last_shared = (0, false);
            for_conditions(arcs, |condition| {
                let place = &mut self.places[condition.place.index()];
                if let Some(shared) = place.as_shared() {
                    let word = shared as usize * words + block / BLOCK;
                    self.users[word] |= 1 << (block % BLOCK);
                    last_shared = (shared, condition.when_marked);
                    shared_count += 1;
                    return;
                }
                if condition.when_marked {
                    conditions[slot] &= !bit;
                }
                if place.add_flip(&mut self.flips, block as u32, slot, bit) {
                    place.witness = Witness {
                        transition: (block * BLOCK + lane) as u16,
                        slot: slot as u8,
                        when_marked: condition.when_marked,
                    };
                }
                slot += 1;
            });
            match shared_count {
                0 => {}
                1 => add_to_gate(&mut self.gates, first_gate, last_shared, bit),
                _ => *several |= bit,
            }
        }
        self.gates_of[block] = span(first_gate, self.gates.len());
    }

    fn users_of(&self, shared: u32) -> &[u64] {
        let words = set_words(self.blocks.len());
        &self.users[shared as usize * words..][..words]
    }
}

/// Adds a transition to the gate of its one shared place, among those from `first` on.
fn add_to_gate(gates: &mut Vec<Gate>, first: usize, (shared, when_marked): (u32, bool), bit: u64) {
    let known = gates[first..].iter().position(|gate| gate.shared == shared);
    let index = known.map_or(gates.len(), |index| first + index);
    if known.is_none() {
        gates.push(Gate {
            shared,
            closed: [0; 2],
        });
    }
    gates[index].closed[usize::from(!when_marked)] |= bit;
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
            specials: Vec::with_capacity(match tables.shared {
                0 => 0,
                _ => structure.transition_count(),
            }),
            tables,
            structure,
            sources,
            sinks,
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

    fn add_block<'b>(&mut self, block: usize, transitions: impl Iterator<Item = Arcs<'b>>) {
        let gates = self.tables.gates_of[block];
        for (gate, index) in gates.of(&self.tables.gates).iter().zip(gates.start..) {
            self.gate_of[gate.shared as usize] = index;
        }
        let several = self.tables.blocks[block].several;
        let has_ports = !self.sources.is_empty() || !self.sinks.is_empty();
        let mut all_own = std::mem::take(&mut self.own);
        for (lane, (arcs, own)) in transitions.zip(&mut all_own[block]).enumerate() {
            let (first_far, first_port) = (self.far.len(), self.ports.len());
            let mut special = Special::NOTHING;
            for_conditions(arcs, |condition| {
                if !condition.changes {
                    return;
                }
                let place = &self.tables.places[condition.place.index()];
                if let Some(shared) = place.as_shared() {
                    let index = self.gate_of[shared as usize];
                    if gates.contains(index) {
                        let gate = &self.tables.gates[index as usize];
                        special.open |= gate.closed[0] | gate.closed[1];
                    }
                    let (word, bits) = (shared / u64::BITS, 1 << (shared % u64::BITS));
                    merge(&mut special.marks, &mut self.marks, WordBits { word, bits });
                    for (&bits, word) in self.tables.users_of(shared).iter().zip(0..) {
                        if bits != 0 {
                            merge(&mut special.wakes, &mut self.wakes, WordBits { word, bits });
                        }
                    }
                    return;
                }
                for flip in place.flips(&self.tables.flips) {
                    if flip.block as usize == block {
                        flip_bits(own, &flip.bits);
                    } else {
                        add_flip(&mut self.far, first_far, flip);
                    }
                }
            });
            if has_ports {
                self.add_ports(arcs);
            }
            let several = several >> lane & 1 == 1;
            let effects = (first_far, first_port) != (self.far.len(), self.ports.len());
            if effects || several || special.marks.bits != 0 {
                if effects || !self.marks.is_empty() || !self.wakes.is_empty() {
                    special.more = self.effects.len() as u32;
                    self.effects.push(Effects {
                        far: span(first_far, self.far.len()),
                        ports: span(first_port, self.ports.len()),
                        marks: append(&mut self.word_bits, &mut self.marks),
                        wakes: append(&mut self.word_bits, &mut self.wakes),
                    });
                }
                if several {
                    special.needs = self.add_needs(arcs);
                }
                self.tables.blocks[block].special |= 1 << lane;
                self.specials.resize(block * BLOCK + lane, Special::NOTHING);
                self.specials.push(special);
            }
        }
        self.own = all_own;
    }

    fn add_ports(&mut self, arcs: Arcs) {
        for_conditions(arcs, |condition| {
            if !condition.changes {
                return;
            }
            let index_of = |ports: &[(PlaceId, EventId)]| {
                ports.partition_point(|&(place, _)| place < condition.place) as u16
            };
            self.ports
                .extend(match self.structure.kind(condition.place) {
                    PlaceKind::Internal => None,
                    PlaceKind::Source => Some(PortChange::SourceEmptied(index_of(self.sources))),
                    PlaceKind::Sink => Some(PortChange::SinkFilled(index_of(self.sinks))),
                });
        });
    }

    /// What a transition needs of several shared places.
    fn add_needs(&mut self, arcs: Arcs) -> Span {
        self.needed.clear();
        for_conditions(arcs, |condition| {
            let place = &self.tables.places[condition.place.index()];
            if let Some(shared) = place.as_shared() {
                self.needed.push((shared, condition.when_marked));
            }
        });
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
            flips: tables.flips,
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
fn merge(first: &mut WordBits, others: &mut Vec<WordBits>, more: WordBits) {
    if first.bits == 0 || first.word == more.word {
        first.word = more.word;
        first.bits |= more.bits;
        return;
    }
    let mut known = others.iter_mut();
    match known.find(|known| known.word == more.word) {
        Some(known) => known.bits |= more.bits,
        None => others.push(more),
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
