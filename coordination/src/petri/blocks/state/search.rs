//! Which transition is next; see [blocks](crate::petri::blocks).

use super::net_state::State;
use crate::petri::bits::{above, lowest};
use crate::petri::blocks::layout::{BLOCK, Layout, Words};

/// The blocks behind one, in turn.
pub(super) enum Search {
    /// The first that has ready transitions.
    Found(usize, Words),
    Nothing,
    /// The looks are used up; this was the last block.
    CutShort(usize),
}

impl State {
    /// The first of these transitions whose needs of several shared places, if any, are met.
    #[inline]
    pub(super) fn choose(&self, layout: &Layout, block: usize, mut ready: u64) -> Option<usize> {
        loop {
            let lane = lowest(ready)?;
            if self.blocks[block].several >> lane & 1 == 0 || self.is_met(layout, block, lane) {
                return Some(lane);
            }
            ready &= ready - 1;
        }
    }

    /// As [`choose`](Self::choose), behind `last`; or from the beginning of the block again if no
    /// other block is to come before.
    #[inline]
    pub(super) fn choose_behind(
        &self,
        layout: &Layout,
        block: usize,
        ready: u64,
        last: usize,
    ) -> Option<usize> {
        match self.choose(layout, block, ready & above(last)) {
            None if self.is_alone(block) => self.choose(layout, block, ready),
            next => next,
        }
    }

    /// Whether surely no other block is active.
    #[inline]
    pub(super) fn is_alone(&self, block: usize) -> bool {
        self.sets.len() == 1 && self.sets[0].active & !(1 << block) == 0
    }

    #[inline]
    pub(super) fn is_met(&self, layout: &Layout, block: usize, lane: usize) -> bool {
        let needs = layout.needs_of[block * BLOCK + lane];
        let mut needs = needs.of(&layout.needs).iter();
        needs.all(|need| self.marks[need.word as usize] & need.care == need.value)
    }

    /// The next block behind `block`, wrapping around to it, that has ready transitions.
    #[inline(never)]
    pub(super) fn next_active(&mut self, layout: &Layout, block: usize, looks: &mut u32) -> Search {
        let mut word = block / BLOCK;
        let mut among = above(block % BLOCK);
        for _ in 0..=self.sets.len() {
            while let Some(lane) = lowest(self.sets[word].active & among) {
                let block = word * BLOCK + lane;
                let words = self.words(layout, block);
                if self.choose(layout, block, words.ready()).is_some() {
                    return Search::Found(block, words);
                }
                self.set_active(block, false);
                *looks = looks.saturating_sub(1);
                if *looks == 0 {
                    return Search::CutShort(block);
                }
            }
            word = if word + 1 < self.sets.len() {
                word + 1
            } else {
                0
            };
            among = !0;
        }
        Search::Nothing
    }

    pub(super) fn may_find(&mut self, layout: &Layout, block: usize, looks: &mut u32) -> bool {
        !matches!(self.next_active(layout, block, looks), Search::Nothing)
    }

    /// Whether a transition is enabled, or may be, if the search for one is cut short; between two
    /// rounds only, when all that are enabled are ready.
    #[inline(never)]
    pub(super) fn is_any_enabled(&mut self, layout: &Layout, looks: &mut u32) -> bool {
        let block = self.last / BLOCK;
        let ready = self.words(layout, block).ready();
        self.choose(layout, block, ready).is_some() || self.may_find(layout, block, looks)
    }
}
