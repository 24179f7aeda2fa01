//! Firing; see [blocks](crate::petri::blocks).

use super::net_state::State;
use super::search::Search;
use crate::petri::bits::{lowest, next_behind};
use crate::petri::blocks::layout::{BLOCK, Block, Flip, Layout, More, Special, Words};
use crate::petri::evaluation::Allowance;
use crate::petri::ports::{PortChange, Ports};

impl State {
    /// Fires one transition, unless none is ready or the next one needs several shared places.
    /// Returns which one, and whether a transition is enabled then. This is the shortest way for the
    /// most frequent case. Between two evaluations only.
    #[inline(always)]
    pub(in crate::petri) fn step(
        &mut self,
        layout: &Layout,
        ports: &mut Ports,
        looks: u32,
    ) -> Option<(usize, bool)> {
        let block = self.last / BLOCK;
        let words = Words {
            conditions: self.blocks[block].conditions,
            open: self.open,
            fresh: !0,
        };
        let lane = match next_behind(words.enabled(), self.last % BLOCK) {
            Some(lane) => lane,
            None if self.is_alone(block) => lowest(words.enabled())?,
            None => return self.step_elsewhere(layout, ports, looks),
        };
        self.fire_one(layout, ports, block, words, lane, looks)
    }

    /// As [`step`](Self::step), if nothing is ready behind the last in its block.
    #[inline(never)]
    fn step_elsewhere(
        &mut self,
        layout: &Layout,
        ports: &mut Ports,
        mut looks: u32,
    ) -> Option<(usize, bool)> {
        let block = self.last / BLOCK;
        // Those before it have their turn after all other blocks.
        self.set_active(block, true);
        let Search::Found(next, words) = self.next_active(layout, block, &mut looks) else {
            return None;
        };
        let lane = lowest(words.enabled())?;
        self.fire_one(layout, ports, next, words, lane, looks)
    }

    #[inline(always)]
    fn fire_one(
        &mut self,
        layout: &Layout,
        ports: &mut Ports,
        block: usize,
        mut words: Words,
        lane: usize,
        mut looks: u32,
    ) -> Option<(usize, bool)> {
        let Block {
            special, several, ..
        } = self.blocks[block];
        let transition = block * BLOCK + lane;
        words.flip(&layout.own[block][lane % BLOCK]);
        if special >> lane & 1 == 1 {
            if several >> lane & 1 == 1 {
                return None;
            }
            words.open ^= self.apply_special(layout, ports, &layout.specials[transition]);
        }
        self.blocks[block].conditions = words.conditions;
        self.open = words.open;
        self.last = transition;
        let enabled = match words.enabled() {
            0 => self.may_find(layout, block, &mut looks),
            enabled => enabled & !several != 0 || self.is_any_enabled(layout, &mut looks),
        };
        Some((transition, enabled))
    }

    /// Fires as far as `left` allows, and uses it up. Each round begins behind the last that fired:
    /// first what is behind it in its block, then block by block, at last the rest of its block.
    /// Returns whether a transition is enabled, or may be, if the search for one was cut short.
    #[inline(never)]
    pub(in crate::petri) fn run(
        &mut self,
        layout: &Layout,
        ports: &mut Ports,
        left: &mut Allowance,
        mut on_fire: impl FnMut(usize),
    ) -> bool {
        loop {
            if left.firings == 0 || left.rounds == 0 {
                return self.is_any_enabled(layout, &mut left.looks);
            }
            let block = self.last / BLOCK;
            let mut behind = Some(self.last % BLOCK);
            let mut next = Search::Found(block, self.words(layout, block));
            while let Search::Found(block, words) = next {
                let firings = &mut left.firings;
                self.run_block(layout, ports, block, words, behind, firings, &mut on_fire);
                behind = None;
                next = match left.firings {
                    0 => Search::Nothing,
                    _ => self.next_active(layout, block, &mut left.looks),
                };
            }
            if self.any_used {
                self.begin_round();
            }
            if let Search::CutShort(block) = next {
                // The next evaluation goes on behind it.
                self.last = (block * BLOCK + BLOCK - 1).min(layout.transitions - 1);
                self.open = self.open_of(layout, block);
                return true;
            }
            left.rounds -= 1;
            if left.firings > 0 && left.rounds > 0 && !self.is_any_enabled(layout, &mut left.looks)
            {
                return false;
            }
        }
    }

    /// Fires the ready transitions of `block` in order, beginning `behind` this one, until none
    /// behind the last is ready or `left` is used up.
    #[expect(clippy::too_many_arguments, reason = "they are to be in registers")]
    fn run_block(
        &mut self,
        layout: &Layout,
        ports: &mut Ports,
        block: usize,
        mut words: Words,
        behind: Option<usize>,
        left: &mut u32,
        mut on_fire: impl FnMut(usize),
    ) {
        let special = self.blocks[block].special;
        let mut next = match behind {
            Some(last) => self.choose_behind(layout, block, words.ready(), last),
            None => self.choose(layout, block, words.ready()),
        };
        if next.is_some() {
            while let Some(lane) = next {
                let on_fire = |lane| on_fire(block * BLOCK + lane);
                let last = if special >> lane & 1 == 0 {
                    words.run_plain(&layout.own[block], special, lane, left, on_fire)
                } else {
                    self.run_special(layout, ports, block, &mut words, lane, left, on_fire)
                };
                self.last = block * BLOCK + last;
                next = match left {
                    0 => None,
                    _ => self.choose_behind(layout, block, words.ready(), last),
                };
            }
            self.blocks[block].conditions = words.conditions;
            self.blocks[block].fresh = words.fresh;
            self.open = words.open;
            self.sets[block / BLOCK].used |= 1 << (block % BLOCK);
            self.any_used = true;
        }
        let active = self.choose(layout, block, words.ready()).is_some();
        self.set_active(block, active);
    }

    /// As [`Words::run_plain`], for special transitions; all but the first need at most one shared
    /// place.
    #[inline(never)]
    #[expect(clippy::too_many_arguments, reason = "they are to be in registers")]
    fn run_special(
        &mut self,
        layout: &Layout,
        ports: &mut Ports,
        block: usize,
        words: &mut Words,
        mut lane: usize,
        left: &mut u32,
        mut on_fire: impl FnMut(usize),
    ) -> usize {
        let flips = &layout.own[block];
        let Block {
            special, several, ..
        } = self.blocks[block];
        let mut now = *words;
        let mut more = *left;
        loop {
            now.fire(flips, lane);
            on_fire(lane);
            let special_one = &layout.specials[block * BLOCK + lane];
            now.open ^= self.apply_special(layout, ports, special_one);
            more -= 1;
            if more == 0 {
                break;
            }
            match next_behind(now.ready(), lane) {
                Some(next) if (special & !several) >> next & 1 == 1 => lane = next,
                _ => break,
            }
        }
        *words = now;
        *left = more;
        lane
    }

    /// What a special firing changes beside the conditions of its block. Returns the flips in `open`.
    #[inline(always)]
    fn apply_special(&mut self, layout: &Layout, ports: &mut Ports, special: &Special) -> u64 {
        self.marks[usize::from(special.marks_word)] ^= special.marks;
        self.sets[usize::from(special.wakes_word)].active |= special.wakes;
        if special.more != Special::NO_MORE {
            self.apply_more(layout, ports, &layout.more[special.more as usize]);
        }
        special.open
    }

    #[inline(never)]
    fn apply_more(&mut self, layout: &Layout, ports: &mut Ports, more: &More) {
        for marks in more.marks.of(&layout.word_bits) {
            self.marks[usize::from(marks.word)] ^= marks.bits;
        }
        for blocks in more.wakes.of(&layout.word_bits) {
            self.sets[usize::from(blocks.word)].active |= blocks.bits;
        }
        for flip in more.far.of(&layout.far) {
            self.flip_conditions(flip);
            self.look_at(flip.block as usize);
        }
        for change in more.ports.of(&layout.port_changes) {
            match *change {
                PortChange::SourceEmptied(source) => ports.emptied(usize::from(source)),
                PortChange::SinkFilled(sink) => ports.filled(usize::from(sink)),
            }
        }
    }

    fn flip_conditions(&mut self, flip: &Flip) {
        let block = &mut self.blocks[flip.block as usize];
        for (bits, flips) in block.conditions.iter_mut().zip(&flip.bits) {
            *bits ^= flips;
        }
    }
}
