//! The marking of a net and what is kept beside it; see [blocks](crate::petri::blocks).

use alloc::boxed::Box;
use alloc::vec;

use crate::petri::bits::lowest;
use crate::petri::blocks::layout::{BLOCK, Block, Layout, Words, users_of};
use crate::petri::id::PlaceId;

/// The marking of a net, what has fired in this round, and what fired last.
#[derive(Clone, Debug)]
pub(in crate::petri) struct State {
    pub(super) blocks: Box<[Block]>,
    /// The marks of the shared places, one bit each.
    pub(super) marks: Box<[u64]>,
    /// The transition that fired last.
    pub(super) last: usize,
    /// Of the block of `last`.
    pub(super) open: u64,
    /// Sets of blocks, 64 by 64.
    pub(super) sets: Box<[Sets]>,
    /// Whether some block is `used`.
    pub(super) any_used: bool,
}

/// A bit per block.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Sets {
    /// May have ready transitions.
    pub(super) active: u64,
    /// Some bit of its `fresh` is 0.
    pub(super) used: u64,
}

impl State {
    /// With these blocks, and these shared places marked.
    pub(in crate::petri) fn new(layout: &Layout, blocks: Box<[Block]>, marks: Box<[u64]>) -> Self {
        let mut state = Self {
            sets: vec![Sets::default(); blocks.len().div_ceil(BLOCK)].into(),
            blocks,
            marks,
            last: layout.transitions - 1,
            open: 0,
            any_used: false,
        };
        state.open = state.open_of(layout, state.last / BLOCK);
        for block in 0..state.blocks.len() {
            state.look_at(block);
        }
        state
    }

    /// Makes this a copy of a state of the same net.
    pub(in crate::petri) fn copy_from(&mut self, other: &Self) {
        self.blocks.copy_from_slice(&other.blocks);
        self.marks.copy_from_slice(&other.marks);
        self.last = other.last;
        self.open = other.open;
        self.sets.copy_from_slice(&other.sets);
        self.any_used = other.any_used;
    }

    pub(in crate::petri) fn is_marked(&self, layout: &Layout, place: PlaceId) -> bool {
        let place = &layout.places[place.index()];
        if let Some(shared) = place.as_shared() {
            return self.is_shared_marked(shared);
        }
        // All conditions on it tell the same; there is one, as no place is without an arc.
        let position = place.positions(&layout.positions)[0];
        let word = self.blocks[position.block()].conditions[position.slot()];
        position.when_marked() == (word & position.bit() != 0)
    }

    /// Marks a place that is empty or empties one that is marked. Between two evaluations only.
    pub(in crate::petri) fn flip(&mut self, layout: &Layout, place: PlaceId) {
        let place = &layout.places[place.index()];
        if let Some(shared) = place.as_shared() {
            self.marks[shared as usize / BLOCK] ^= 1 << (shared as usize % BLOCK);
            let is_marked = self.is_shared_marked(shared);
            let users = users_of(&layout.users, self.blocks.len(), shared, is_marked);
            for (sets, users) in self.sets.iter_mut().zip(users) {
                sets.active |= users;
            }
            self.open = self.open_of(layout, self.last / BLOCK);
        }
        for position in place.positions(&layout.positions) {
            let conditions = &mut self.blocks[position.block()].conditions;
            conditions[position.slot()] ^= position.bit();
            self.look_at(position.block());
        }
    }

    #[inline]
    pub(super) fn words(&self, layout: &Layout, block: usize) -> Words {
        let Block {
            conditions, fresh, ..
        } = self.blocks[block];
        let open = if block == self.last / BLOCK {
            self.open
        } else {
            self.open_of(layout, block)
        };
        Words {
            conditions,
            open,
            fresh,
        }
    }

    /// The `open` of a block.
    #[inline]
    pub(super) fn open_of(&self, layout: &Layout, block: usize) -> u64 {
        let mut open = !0;
        for gate in layout.gates_of[block].of(&layout.gates) {
            open &= !gate.closed[usize::from(self.is_shared_marked(gate.shared))];
        }
        open
    }

    #[inline]
    pub(super) fn is_shared_marked(&self, shared: u32) -> bool {
        self.marks[shared as usize / BLOCK] >> (shared as usize % BLOCK) & 1 == 1
    }

    /// Lets every transition fire again; costs what has fired.
    pub(super) fn begin_round(&mut self) {
        self.any_used = false;
        for word in 0..self.sets.len() {
            while let Some(lane) = lowest(self.sets[word].used) {
                self.sets[word].used &= !(1 << lane);
                self.blocks[word * BLOCK + lane].fresh = !0;
                self.look_at(word * BLOCK + lane);
            }
        }
    }

    /// Puts a block into the active ones, or out of them if its local conditions say that nothing is
    /// ready.
    #[inline]
    pub(super) fn look_at(&mut self, block: usize) {
        let Block {
            conditions: [a, b, c, d],
            fresh,
            ..
        } = self.blocks[block];
        self.set_active(block, a & b & c & d & fresh != 0);
    }

    #[inline]
    pub(super) fn set_active(&mut self, block: usize, active: bool) {
        let word = &mut self.sets[block / BLOCK].active;
        let lane = block % BLOCK;
        *word = (*word & !(1 << lane)) | u64::from(active) << lane;
    }
}
