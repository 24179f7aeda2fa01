//! Where each condition is, and what the firings of a block flip in it; see [blocks](crate::petri::blocks).

use alloc::vec;
use alloc::vec::Vec;

use super::places::Places;
use crate::petri::bits::lowest;
use crate::petri::blocks::layout::{
    BLOCK, Bits, Block, Gate, PlaceEntry, Position, SLOTS, set_words,
};
use crate::petri::demand::{Demand, for_conditions};
use crate::petri::model::{PlaceKind, Structure};
use crate::petri::span::{Span, span};

/// The conditions of one transition.
struct Conditions<'a> {
    transition: usize,
    /// The words of its block.
    words: &'a mut Bits,
    /// What it flips in its own block.
    own: &'a mut Bits,
    /// How many are on local places.
    local: usize,
    /// Whether other blocks mention one of them.
    is_far: bool,
    /// How many are on shared places.
    shared: usize,
    /// The last of these.
    last_shared: (u32, Demand),
}

impl Conditions<'_> {
    #[inline(always)]
    fn add(&mut self, place: &mut PlaceEntry, positions: &mut [Position], demand: Demand) {
        if let Some(shared) = place.as_shared() {
            self.last_shared = (shared, demand);
            self.shared += 1;
            return;
        }
        positions[place.next_position()] = Position::new(self.transition, self.local, demand);
        let slot = self.local % SLOTS;
        self.local += 1;
        let lane = self.transition % BLOCK;
        self.words[slot] ^= u64::from(!demand.is_met(place.is_marked())) << lane;
        self.own[slot] = u64::from(demand.changes()) << lane;
        self.is_far |= place.is_in_several_blocks();
    }
}

/// Where each condition is.
pub(in crate::petri) struct Tables {
    /// In the initial marking.
    pub(in crate::petri) blocks: Vec<Block>,
    pub(in crate::petri) places: Vec<PlaceEntry>,
    pub(in crate::petri) positions: Vec<Position>,
    pub(in crate::petri) gates_of: Vec<Span>,
    pub(in crate::petri) gates: Vec<Gate>,
    /// By block: the transitions that are special only since they change the place of a gate.
    pub(in crate::petri) gated: Vec<u64>,
    pub(in crate::petri) shared: usize,
    /// By shared place: index of its gate in the block at hand, if that is in the block's span.
    pub(in crate::petri) gate_of: Vec<u32>,
    pub(in crate::petri) own: Vec<[Bits; BLOCK]>,
    /// As `Layout::users`.
    pub(in crate::petri) users: Vec<u64>,
}

impl Tables {
    pub(in crate::petri) fn new(structure: &Structure) -> Self {
        let transitions = structure.transition_count();
        let Places {
            places,
            shared,
            positions,
        } = Places::new(structure);
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
            positions: vec![Position::default(); positions],
            places,
            gates_of: vec![Span::default(); block_count],
            gates: Vec::new(),
            gated: vec![0; block_count],
            shared,
            gate_of: vec![u32::MAX; shared],
            own: vec![[[0; SLOTS]; BLOCK]; block_count],
            users: vec![0; 2 * shared * set_words(block_count)],
        }
    }

    /// Adds the conditions of the transitions of a block, and what their firings flip of them.
    pub(in crate::petri) fn add_block(
        &mut self,
        block: usize,
        structure: &Structure,
        has_ports: bool,
    ) {
        let first = block * BLOCK;
        let behind = structure.transition_count().min(first + BLOCK);
        let first_gate = self.gates.len();
        let (places, positions) = (&mut self.places[..], &mut self.positions[..]);
        let mut words = self.blocks[block].conditions;
        let mut others = 0;
        for (transition, own) in (first..behind).zip(&mut self.own[block]) {
            let arcs = structure.arcs_of(transition);
            let mut one = Conditions {
                transition,
                words: &mut words,
                own,
                local: 0,
                is_far: has_ports || arcs.has_self_loop,
                shared: 0,
                last_shared: (0, Demand::Marked),
            };
            if arcs.has_self_loop {
                for_conditions(arcs, |place, demand| {
                    one.add(&mut places[place.index()], positions, demand);
                });
            } else {
                let (inputs, outputs) = arcs.places.split_at(arcs.inputs);
                for place in inputs {
                    one.add(&mut places[place.index()], positions, Demand::Marked);
                }
                for place in outputs {
                    one.add(&mut places[place.index()], positions, Demand::Empty);
                }
            }
            let bit = 1 << (transition % BLOCK);
            if one.shared == 1 {
                let (shared, demand) = one.last_shared;
                let gate = &mut self.gate_of[shared as usize];
                if !(first_gate..self.gates.len()).contains(&(*gate as usize)) {
                    *gate = self.gates.len() as u32;
                    self.gates.push(Gate::new(shared));
                }
                self.gates[*gate as usize].closed[usize::from(!demand.is_met(true))] |= bit;
                self.gated[block] |= bit;
            }
            if one.is_far || one.shared > 1 {
                others |= bit;
            }
        }
        self.blocks[block].conditions = words;
        self.blocks[block].special = self.gated[block];
        self.gates_of[block] = span(first_gate, self.gates.len());
        let words = set_words(self.blocks.len());
        for gate in &self.gates[first_gate..] {
            for (closed, when_marked) in gate.closed.into_iter().zip([true, false]) {
                if closed != 0 {
                    let users = users_of(&mut self.users, words, gate.shared, when_marked);
                    users[block / BLOCK] |= 1 << (block % BLOCK);
                }
            }
        }
        if words > 1 {
            others |= self.gated[block];
        }
        self.gated[block] &= !others;
        while let Some(lane) = lowest(others) {
            others &= others - 1;
            self.add_other(block, lane, structure);
        }
    }

    /// Finds out whether a transition is special, and which shared places it needs, if several.
    fn add_other(&mut self, block: usize, lane: usize, structure: &Structure) {
        let words = set_words(self.blocks.len());
        let mut is_special = false;
        let mut shared_count = 0;
        for_conditions(structure.arcs_of(block * BLOCK + lane), |place, demand| {
            is_special |= structure.kind(place) != PlaceKind::Internal;
            let place = &self.places[place.index()];
            is_special |= place.is_in_several_blocks() && demand.changes();
            if let Some(shared) = place.as_shared() {
                let users = users_of(&mut self.users, words, shared, demand.is_met(true));
                users[block / BLOCK] |= 1 << (block % BLOCK);
                shared_count += 1;
            }
        });
        let several = shared_count > 1;
        let block = &mut self.blocks[block];
        block.several |= u64::from(several) << lane;
        block.special &= !(1 << lane);
        block.special |= u64::from(is_special || several) << lane;
    }

    /// Adds what a firing of each transition flips of others in its own block: for each place that
    /// it changes, all conditions on it.
    pub(in crate::petri) fn add_flips_of_others(&mut self) {
        let own: &mut [Bits] = self.own.as_flattened_mut();
        for place in &self.places {
            match *place.positions(&self.positions) {
                [] => {}
                // Most places have one transition before and one behind.
                [a, b] => {
                    if a.block() == b.block() {
                        own[a.transition()][b.slot()] |= if a.changes() { b.bit() } else { 0 };
                        own[b.transition()][a.slot()] |= if b.changes() { a.bit() } else { 0 };
                    }
                }
                ref few if place.is_in_several_blocks() => {
                    for by in few.iter().filter(|by| by.changes()) {
                        let own = &mut own[by.transition()];
                        for position in few {
                            let is_here = position.block() == by.block();
                            own[position.slot()] |= if is_here { position.bit() } else { 0 };
                        }
                    }
                }
                // They are all in one block.
                ref many => {
                    let mut flips = [0; SLOTS];
                    for position in many {
                        flips[position.slot()] |= position.bit();
                    }
                    for by in many.iter().filter(|by| by.changes()) {
                        for (own, flips) in own[by.transition()].iter_mut().zip(&flips) {
                            *own |= flips;
                        }
                    }
                }
            }
        }
    }
}

fn users_of(users: &mut [u64], words: usize, shared: u32, when_marked: bool) -> &mut [u64] {
    let set = 2 * shared as usize + usize::from(when_marked);
    &mut users[set * words..][..words]
}
