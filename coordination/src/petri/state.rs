//! What changes while a net runs; see [the layout](super::layout).

use super::layout::{BLOCK, Block, Flip, Layout, More, PortChange, Special, users_of};
use super::net::PlaceId;
use super::ports::Ports;
use super::words::{Words, above, lowest, next_behind};

/// The marking of a net, what has fired in this round, and what fired last.
#[derive(Clone, Debug)]
pub(super) struct State {
    blocks: Box<[Block]>,
    /// The marks of the shared places, one bit each.
    marks: Box<[u64]>,
    /// The transition that fired last.
    last: usize,
    /// Of the block of `last`.
    open: u64,
    /// Sets of blocks, 64 by 64.
    sets: Box<[Sets]>,
    /// Whether some block is `used`.
    any_used: bool,
}

/// A bit per block.
#[derive(Clone, Copy, Debug, Default)]
struct Sets {
    /// May have ready transitions.
    active: u64,
    /// Some bit of its `fresh` is 0.
    used: u64,
}

/// How much may still happen in an evaluation.
#[derive(Clone, Copy, Debug)]
pub(super) struct Allowance {
    pub(super) firings: u32,
    pub(super) rounds: u32,
    /// Looks in vain; a search ends when they are used up, but not before its first one.
    pub(super) looks: u32,
}

/// The blocks behind one, in turn.
enum Search {
    /// The first that has ready transitions.
    Found(usize, Words),
    Nothing,
    /// The looks are used up; this was the last block.
    CutShort(usize),
}

impl State {
    /// With these blocks, and these shared places marked.
    pub(super) fn new(layout: &Layout, blocks: Box<[Block]>, marks: Box<[u64]>) -> Self {
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
    pub(super) fn copy_from(&mut self, other: &Self) {
        self.blocks.copy_from_slice(&other.blocks);
        self.marks.copy_from_slice(&other.marks);
        self.last = other.last;
        self.open = other.open;
        self.sets.copy_from_slice(&other.sets);
        self.any_used = other.any_used;
    }

    pub(super) fn is_marked(&self, layout: &Layout, place: PlaceId) -> bool {
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
    pub(super) fn flip(&mut self, layout: &Layout, place: PlaceId) {
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

    /// Fires one transition, unless none is ready or the next one needs several shared places.
    /// Returns which one, and whether a transition is enabled then. This is the shortest way for the
    /// most frequent case. Between two evaluations only.
    #[inline(always)]
    pub(super) fn step(
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
    pub(super) fn run(
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

    /// The first of these transitions whose needs of several shared places, if any, are met.
    #[inline]
    fn choose(&self, layout: &Layout, block: usize, mut ready: u64) -> Option<usize> {
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
    fn choose_behind(
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
    fn is_alone(&self, block: usize) -> bool {
        self.sets.len() == 1 && self.sets[0].active & !(1 << block) == 0
    }

    fn is_met(&self, layout: &Layout, block: usize, lane: usize) -> bool {
        let needs = layout.needs_of[block * BLOCK + lane];
        let mut needs = needs.of(&layout.needs).iter();
        needs.all(|need| self.marks[need.word as usize] & need.care == need.value)
    }

    fn words(&self, layout: &Layout, block: usize) -> Words {
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
    fn open_of(&self, layout: &Layout, block: usize) -> u64 {
        let mut open = !0;
        for gate in layout.gates_of[block].of(&layout.gates) {
            open &= !gate.closed[usize::from(self.is_shared_marked(gate.shared))];
        }
        open
    }

    fn is_shared_marked(&self, shared: u32) -> bool {
        self.marks[shared as usize / BLOCK] >> (shared as usize % BLOCK) & 1 == 1
    }

    /// The next block behind `block`, wrapping around to it, that has ready transitions.
    #[inline(never)]
    fn next_active(&mut self, layout: &Layout, block: usize, looks: &mut u32) -> Search {
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

    fn may_find(&mut self, layout: &Layout, block: usize, looks: &mut u32) -> bool {
        !matches!(self.next_active(layout, block, looks), Search::Nothing)
    }

    /// Whether a transition is enabled, or may be, if the search for one is cut short; between two
    /// rounds only, when all that are enabled are ready.
    #[inline(never)]
    fn is_any_enabled(&mut self, layout: &Layout, looks: &mut u32) -> bool {
        let block = self.last / BLOCK;
        let ready = self.words(layout, block).ready();
        self.choose(layout, block, ready).is_some() || self.may_find(layout, block, looks)
    }

    /// Lets every transition fire again; costs what has fired.
    fn begin_round(&mut self) {
        self.any_used = false;
        for word in 0..self.sets.len() {
            while let Some(lane) = lowest(self.sets[word].used) {
                self.sets[word].used &= !(1 << lane);
                self.blocks[word * BLOCK + lane].fresh = !0;
                self.look_at(word * BLOCK + lane);
            }
        }
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

    /// Puts a block into the active ones, or out of them if its local conditions say that nothing is
    /// ready.
    fn look_at(&mut self, block: usize) {
        let Block {
            conditions: [a, b, c, d],
            fresh,
            ..
        } = self.blocks[block];
        self.set_active(block, a & b & c & d & fresh != 0);
    }

    fn set_active(&mut self, block: usize, active: bool) {
        let word = &mut self.sets[block / BLOCK].active;
        let lane = block % BLOCK;
        *word = (*word & !(1 << lane)) | u64::from(active) << lane;
    }
}
