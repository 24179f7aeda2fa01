//! The marking of a net, and what is to be looked at; see [masks](super).

use alloc::boxed::Box;

use super::layout::{BITS, Layout};
use crate::petri::bits::{above, lowest};
use crate::petri::id::PlaceId;

/// Up to 64 transitions.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub(in crate::petri) struct Block {
    /// The places that only they mention, and the shared ones; those are up to date in the block that runs.
    pub(in crate::petri) marks: u64,
    /// The first transition.
    pub(in crate::petri) first: usize,
    /// Those to look at.
    pub(in crate::petri) todo: u64,
    /// The transition behind the last.
    pub(in crate::petri) end: usize,
    /// Those that have not fired in this round.
    pub(in crate::petri) fresh: u64,
    /// Those that mention shared places.
    pub(in crate::petri) on_shared: u64,
}

#[derive(Clone, Debug)]
pub(in crate::petri) struct State {
    /// The block that runs.
    pub(super) now: Block,
    /// The transition that fired last.
    pub(super) last: usize,
    /// The transition that is next to fire, or [`Self::UNKNOWN`].
    pub(super) next: usize,
    /// The marks of the shared places, as the other blocks know of.
    pub(super) told: u64,
    /// Index of the block that runs.
    pub(super) block: usize,
    /// Index of the block of `last`, if that is not the one that runs.
    pub(super) last_block: usize,
    /// Blocks that may have something to do.
    pub(super) active: u64,
    /// Blocks with a bit of `fresh` that is 0.
    pub(super) used: u64,
    /// All blocks; empty if there is only one.
    pub(super) blocks: Box<[Block]>,
}

impl State {
    /// No transition has this number, nor the one behind it.
    pub(super) const UNKNOWN: usize = usize::MAX - 1;

    /// With `now` as the only block, or `blocks`. Everything is to do, and the last transition counts
    /// as the one that fired last.
    pub(super) fn new(now: Block, blocks: Box<[Block]>, shared: u64) -> Self {
        let block = blocks.len().saturating_sub(1);
        let now = blocks.last().copied().unwrap_or(now);
        Self {
            last: now.end - 1,
            now,
            next: Self::UNKNOWN,
            told: now.marks & shared,
            block,
            last_block: block,
            active: !0 >> (BITS - 1 - block),
            used: 0,
            blocks,
        }
    }

    #[inline]
    pub(super) fn is_one_block(&self) -> bool {
        self.blocks.is_empty()
    }

    /// Makes this a copy of a state of the same net.
    pub(in crate::petri) fn copy_from(&mut self, other: &Self) {
        let blocks = core::mem::take(&mut self.blocks);
        *self = Self { blocks, ..*other };
        self.blocks.copy_from_slice(&other.blocks);
    }

    pub(in crate::petri) fn is_marked(&self, layout: &Layout, place: PlaceId) -> bool {
        let spot = layout.spot(place);
        let block = usize::from(spot.block);
        let marks = match spot.is_shared() || block == self.block {
            true => self.now.marks,
            false => self.blocks[block].marks,
        };
        marks & spot.mask() != 0
    }

    /// Marks a place that is empty or empties one that is marked. Between two evaluations only.
    pub(in crate::petri) fn flip(&mut self, layout: &Layout, place: PlaceId) {
        let spot = layout.spot(place);
        let is_marked = !self.is_marked(layout, place);
        self.next = Self::UNKNOWN;
        if spot.is_shared() {
            let wakes = layout.neighbours(spot.bit.into(), is_marked);
            self.now.marks ^= spot.mask();
            self.told ^= spot.mask();
            self.active |= wakes;
            if wakes >> self.block & 1 == 1 {
                self.now.todo |= self.now.on_shared;
            }
            return;
        }
        let block = usize::from(spot.block);
        let wakes = layout.users[block * BITS + usize::from(spot.bit)][usize::from(is_marked)];
        self.active |= 1 << block;
        let block = if block == self.block {
            &mut self.now
        } else {
            &mut self.blocks[block]
        };
        block.marks ^= spot.mask();
        block.todo |= wakes;
    }

    /// Tells the other blocks which shared places have changed.
    #[inline]
    fn tell(&mut self, layout: &Layout) {
        let mut changed = (self.now.marks ^ self.told) & layout.shared;
        while let Some(bit) = lowest(changed) {
            let is_marked = self.now.marks >> bit & 1 == 1;
            self.active |= layout.neighbours(bit, is_marked) & !(1 << self.block);
            changed &= changed - 1;
        }
        self.told = self.now.marks & layout.shared;
    }

    /// Lets another block run. The others know of all that it has to tell.
    fn switch_to(&mut self, layout: &Layout, block: usize) {
        debug_assert_eq!(self.told, self.now.marks & layout.shared);
        if block != self.block {
            let left = &mut self.blocks[self.block];
            left.marks = self.now.marks;
            left.todo = self.now.todo;
            left.fresh = self.now.fresh;
            self.now = self.blocks[block];
            self.now.marks = (self.now.marks & !layout.shared) | self.told;
            self.block = block;
        }
    }

    /// Lets the block run that fired last.
    #[inline]
    pub(super) fn load_last(&mut self, layout: &Layout) {
        if !(self.now.first..self.now.end).contains(&self.last) {
            self.switch_to(layout, self.last_block);
            // A place from outside may have changed since.
            self.now.todo |= self.now.on_shared;
        }
        self.last_block = self.block;
    }

    /// Lets the next active block run, behind the one that does, around to it, that has something to
    /// do among those of its transitions that `among` names; `false` if there is none.
    #[inline(never)]
    pub(super) fn next_block(&mut self, layout: &Layout, among: impl Fn(&Block) -> u64) -> bool {
        self.tell(layout);
        loop {
            let behind = lowest(self.active & above(self.block));
            let Some(block) = behind.or_else(|| lowest(self.active)) else {
                return false;
            };
            self.switch_to(layout, block);
            self.now.todo |= self.now.on_shared;
            if self.now.todo & among(&self.now) != 0 {
                return true;
            }
            self.set_active(false);
        }
    }

    pub(super) fn set_active(&mut self, active: bool) {
        self.active = (self.active & !(1 << self.block)) | u64::from(active) << self.block;
    }
}
