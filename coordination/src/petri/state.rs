//! What changes while a net runs; see [the layout](super::layout).

use super::layout::{
    BLOCK, Bits, Block, CHUNK, Change, Effects, Flip, Layout, OPEN, OpenFlip, PortChange,
};
use super::net::PlaceId;
use super::ports::Ports;

/// The bits above bit `lane`.
#[inline]
fn above(lane: usize) -> u64 {
    (!0 << lane) << 1
}

/// Whether the bit above `lane` is set.
#[inline]
fn follows(bits: u64, lane: usize) -> bool {
    bits >> lane & 2 != 0
}

/// The lowest bit set above `lane`.
#[inline]
fn next_behind(bits: u64, lane: usize) -> Option<usize> {
    // Often that is the next one. To test for just this one lets the processor go on with it before
    // it knows.
    if follows(bits, lane) {
        Some(lane + 1)
    } else {
        lowest(bits & above(lane))
    }
}

#[inline]
fn lowest(bits: u64) -> Option<usize> {
    (bits != 0).then_some(bits.trailing_zeros() as usize)
}

/// The marking of a net, as the truth of its conditions, and what has fired in this round.
#[derive(Clone, Debug)]
pub(super) struct State {
    blocks: Box<[Block]>,
    /// By block, in whole chunks; behind the last block there are bits that are only read.
    open: Box<[u64]>,
    /// By joint: how many of its conditions do not hold.
    unmet: Box<[u32]>,
    /// Sets of blocks, 64 by 64.
    sets: Box<[Sets]>,
    /// Whether a block has `used` set.
    any_used: bool,
}

/// A bit per block.
#[derive(Clone, Copy, Debug, Default)]
struct Sets {
    /// Has ready transitions; or a row has touched it, and nobody has looked since. Not up to date
    /// for the block of the transition that fired last.
    active: u64,
    /// Some bit of its `fresh` is 0.
    used: u64,
}

/// What is left of a budget, and the transition that fired last.
#[derive(Clone, Copy, Debug)]
pub(super) struct Progress {
    pub(super) firings: u32,
    pub(super) rounds: u32,
    pub(super) last: usize,
}

/// The words of a block while it runs, in registers.
#[derive(Clone, Copy, Debug)]
struct Words {
    conditions: Bits,
    open: u64,
    fresh: u64,
}

impl Words {
    /// Puts the conditions back. The block's `open` is up to date; its `fresh` matters only if
    /// another block runs in the same round.
    #[inline]
    fn put(&self, block: &mut Block) {
        block.conditions = self.conditions;
    }

    /// The transitions whose local conditions hold.
    #[inline]
    fn met(&self) -> u64 {
        let [a, b, c, d] = self.conditions;
        a & b & c & d
    }

    #[inline]
    fn enabled(&self) -> u64 {
        self.met() & self.open
    }

    #[inline]
    fn ready(&self) -> u64 {
        self.enabled() & self.fresh
    }

    #[inline]
    fn flip(&mut self, flips: &Bits) {
        let [a, b, c, d] = &mut self.conditions;
        let [flip_a, flip_b, flip_c, flip_d] = flips;
        *a ^= flip_a;
        *b ^= flip_b;
        *c ^= flip_c;
        *d ^= flip_d;
    }

    #[inline]
    fn fire(&mut self, flips: &[Bits; BLOCK], lane: usize) {
        self.flip(&flips[lane % BLOCK]);
        self.fresh &= !(1 << lane);
    }

    /// Fires `lane` and what is ready behind it, at most `left` and up to the next special one.
    /// Returns the last that fired.
    #[inline(never)]
    fn run_plain(
        &mut self,
        flips: &[Bits; BLOCK],
        special: u64,
        mut lane: usize,
        left: &mut u32,
        mut on_fire: impl FnMut(usize),
    ) -> usize {
        let mut now = *self;
        let mut more = *left;
        loop {
            now.fire(flips, lane);
            on_fire(lane);
            more -= 1;
            if more == 0 {
                break;
            }
            match next_behind(now.ready(), lane) {
                Some(next) if special >> next & 1 == 0 => lane = next,
                _ => break,
            }
        }
        *self = now;
        *left = more;
        lane
    }
}

impl State {
    pub(super) fn new(blocks: Box<[Block]>, open: Box<[u64]>, unmet: Box<[u32]>) -> Self {
        let mut state = Self {
            sets: vec![Sets::default(); open.len().div_ceil(BLOCK)].into(),
            blocks,
            open,
            unmet,
            any_used: false,
        };
        for block in 0..state.blocks.len() {
            state.look_at(block);
        }
        state
    }

    /// Makes this a copy of a state of the same net.
    pub(super) fn copy_from(&mut self, other: &Self) {
        self.blocks.copy_from_slice(&other.blocks);
        self.open.copy_from_slice(&other.open);
        self.unmet.copy_from_slice(&other.unmet);
        self.sets.copy_from_slice(&other.sets);
        self.any_used = other.any_used;
    }

    pub(super) fn is_marked(&self, layout: &Layout, place: PlaceId) -> bool {
        let place = &layout.places[place.index()];
        let transition = place.transition as usize;
        let word = match place.slot {
            OPEN => self.open[transition / BLOCK],
            slot => self.blocks[transition / BLOCK].conditions[usize::from(slot)],
        };
        (word >> (transition % BLOCK) & 1 == 1) == place.when_marked
    }

    /// Marks a place that is empty or empties one that is marked.
    pub(super) fn flip(&mut self, layout: &Layout, place: PlaceId) {
        let marked = !self.is_marked(layout, place);
        let place = &layout.places[place.index()];
        if place.is_shared() {
            let change = &layout.shared[place.shared as usize][usize::from(marked)];
            self.change(layout, change);
        }
        for flip in layout.flips_of(place) {
            self.flip_block(flip);
        }
    }

    /// Fires one transition behind `last` in its block, if one is ready there. Returns which one, and
    /// whether a transition is enabled then. The shortest way for the most frequent case; begins
    /// and ends between two evaluations.
    #[inline(always)]
    pub(super) fn step(
        &mut self,
        layout: &Layout,
        ports: &mut Ports,
        last: usize,
    ) -> Option<(usize, bool)> {
        let block = last / BLOCK;
        let mut words = self.words(block);
        let lane = next_behind(words.enabled(), last % BLOCK)?;
        words.flip(&layout.own[block][lane % BLOCK]);
        words.put(&mut self.blocks[block]);
        let special = self.blocks[block].special >> lane & 1 == 1;
        let enabled = if special || words.enabled() == 0 {
            self.end_step(layout, ports, block, lane, words.met())
        } else {
            true
        };
        Some((block * BLOCK + lane, enabled))
    }

    /// What [`step`](Self::step) does seldom; `met` are the transitions whose local conditions hold.
    #[inline(never)]
    fn end_step(
        &mut self,
        layout: &Layout,
        ports: &mut Ports,
        block: usize,
        lane: usize,
        met: u64,
    ) -> bool {
        let special = self.blocks[block].special >> lane & 1 == 1;
        let open = if special {
            self.apply_special(layout, ports, block, lane)
        } else {
            self.open[block]
        };
        met & open != 0 || self.next_active(block).is_some()
    }

    /// Fires as far as `progress` allows, and uses it up. Each round begins behind the last that
    /// fired: first what is behind it in its block, then block by block, at last the rest of its
    /// block. Returns whether a transition is enabled.
    #[inline(never)]
    pub(super) fn run(
        &mut self,
        layout: &Layout,
        ports: &mut Ports,
        progress: &mut Progress,
        mut on_fire: impl FnMut(usize),
    ) -> bool {
        if progress.firings == 0 || progress.rounds == 0 {
            let block = progress.last / BLOCK;
            self.look_at(block);
            return self.next_active(block).is_some();
        }
        loop {
            let mut block = progress.last / BLOCK;
            let mut behind = Some(progress.last % BLOCK);
            let enabled = loop {
                let words = self.run_block(layout, ports, block, behind, progress, &mut on_fire);
                if progress.firings == 0 {
                    break words.enabled();
                }
                self.leave(block, &words);
                match self.next_active(block) {
                    Some(next) => block = next,
                    None => break words.enabled(),
                }
                behind = None;
            };
            if self.any_used {
                self.refresh_used();
            }
            progress.rounds -= 1;
            let any = enabled != 0 || self.next_active(block).is_some();
            if progress.firings == 0 || progress.rounds == 0 || !any {
                return any;
            }
        }
    }

    /// Fires the ready transitions of `block` in order, beginning `behind` this one, until none
    /// behind the last is ready.
    fn run_block(
        &mut self,
        layout: &Layout,
        ports: &mut Ports,
        block: usize,
        behind: Option<usize>,
        progress: &mut Progress,
        mut on_fire: impl FnMut(usize),
    ) -> Words {
        let special = self.blocks[block].special;
        let mut words = self.words(block);
        let mut next = match behind {
            Some(lane) => next_behind(words.ready(), lane),
            None => lowest(words.ready()),
        };
        if next.is_none() {
            return words;
        }
        while let Some(lane) = next {
            let left = &mut progress.firings;
            let on_fire = |lane| on_fire(block * BLOCK + lane);
            let last = if special >> lane & 1 == 0 {
                words.run_plain(&layout.own[block], special, lane, left, on_fire)
            } else {
                self.run_special(layout, ports, block, &mut words, lane, left, on_fire)
            };
            progress.last = block * BLOCK + last;
            next = match progress.firings {
                0 => None,
                _ => next_behind(words.ready(), last),
            };
        }
        words.put(&mut self.blocks[block]);
        words
    }

    /// As [`Words::run_plain`], for transitions that are all special.
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
        let special = self.blocks[block].special;
        let mut now = *words;
        let mut more = *left;
        loop {
            now.fire(flips, lane);
            on_fire(lane);
            now.open = self.apply_special(layout, ports, block, lane);
            more -= 1;
            if more == 0 {
                break;
            }
            match next_behind(now.ready(), lane) {
                Some(next) if special >> next & 1 == 1 => lane = next,
                _ => break,
            }
        }
        *words = now;
        *left = more;
        lane
    }

    #[inline]
    fn words(&self, block: usize) -> Words {
        let Block {
            conditions, fresh, ..
        } = self.blocks[block];
        Words {
            conditions,
            open: self.open[block],
            fresh,
        }
    }

    /// Puts down what a pass through `block` has left behind.
    fn leave(&mut self, block: usize, words: &Words) {
        self.set_active(block, words.ready() != 0);
        if words.fresh != !0 {
            self.blocks[block].fresh = words.fresh;
            self.sets[block / BLOCK].used |= 1 << (block % BLOCK);
            self.any_used = true;
        }
    }

    /// The next block behind `block`, wrapping around to it, that has ready transitions.
    fn next_active(&mut self, block: usize) -> Option<usize> {
        let mut word = block / BLOCK;
        let mut among = above(block % BLOCK);
        for _ in 0..=self.sets.len() {
            loop {
                let active = self.sets[word].active & among;
                if active == 0 {
                    break;
                }
                let block = word * BLOCK + active.trailing_zeros() as usize;
                if self.is_ready(block) {
                    return Some(block);
                }
                self.set_active(block, false);
            }
            word = if word + 1 < self.sets.len() {
                word + 1
            } else {
                0
            };
            among = !0;
        }
        None
    }

    /// Lets the transitions of used blocks fire again; costs what has fired.
    fn refresh_used(&mut self) {
        self.any_used = false;
        for word in 0..self.sets.len() {
            let mut used = std::mem::take(&mut self.sets[word].used);
            while used != 0 {
                let block = word * BLOCK + used.trailing_zeros() as usize;
                used &= used - 1;
                self.blocks[block].fresh = !0;
                self.look_at(block);
            }
        }
    }

    /// What a special firing changes beside the conditions of its block, whose new `open` it returns.
    #[inline(always)]
    fn apply_special(
        &mut self,
        layout: &Layout,
        ports: &mut Ports,
        block: usize,
        lane: usize,
    ) -> u64 {
        let special = &layout.specials[block * BLOCK + lane];
        self.flip_open(&special.open);
        if let Some(unmet) = self.unmet.get_mut(special.joint.joint as usize)
            && change_unmet(unmet, special.joint.unmet)
        {
            self.flip_joint(layout, special.joint.joint);
        }
        if let Some(effects) = layout.effects.get(special.more as usize) {
            self.apply_effects(layout, ports, effects);
        }
        self.open[block]
    }

    #[inline(never)]
    fn apply_effects(&mut self, layout: &Layout, ports: &mut Ports, effects: &Effects) {
        for flip in effects.far.of(&layout.far) {
            self.flip_block(flip);
        }
        for change in effects.ports.of(&layout.port_changes) {
            match *change {
                PortChange::SourceEmptied(source) => ports.emptied(usize::from(source)),
                PortChange::SinkFilled(sink) => ports.filled(usize::from(sink)),
            }
        }
        self.change(layout, &effects.change);
        for change in effects.changes.of(&layout.changes) {
            self.change(layout, change);
        }
    }

    fn flip_block(&mut self, flip: &Flip) {
        let block = &mut self.blocks[flip.block as usize];
        for (bits, flips) in block.conditions.iter_mut().zip(&flip.bits) {
            *bits ^= flips;
        }
        self.look_at(flip.block as usize);
    }

    fn change(&mut self, layout: &Layout, change: &Change) {
        for flip in change.open.of(&layout.open_flips) {
            self.flip_open(flip);
        }
        for change in change.joints.of(&layout.joint_changes) {
            if change_unmet(&mut self.unmet[change.joint as usize], change.unmet) {
                self.flip_joint(layout, change.joint);
            }
        }
    }

    #[inline(never)]
    fn flip_joint(&mut self, layout: &Layout, joint: u32) {
        for flip in layout.joints[joint as usize].of(&layout.open_flips) {
            self.flip_open(flip);
        }
    }

    #[inline]
    fn flip_open(&mut self, flip: &OpenFlip) {
        // A copy cannot overlap, so several words can be flipped at once.
        let bits = flip.bits;
        let chunk = flip.chunk as usize;
        let open = &mut self.open[chunk * CHUNK..chunk * CHUNK + CHUNK];
        for (open, bits) in open.iter_mut().zip(bits) {
            *open ^= bits;
        }
        self.sets[chunk / (BLOCK / CHUNK)].active |= flip.blocks;
    }

    fn is_ready(&self, block: usize) -> bool {
        self.words(block).ready() != 0
    }

    fn look_at(&mut self, block: usize) {
        self.set_active(block, self.is_ready(block));
    }

    fn set_active(&mut self, block: usize, active: bool) {
        let word = &mut self.sets[block / BLOCK].active;
        let lane = block % BLOCK;
        *word = (*word & !(1 << lane)) | u64::from(active) << lane;
    }
}

/// Changes the number of conditions that do not hold; whether it reached or left zero.
#[inline]
fn change_unmet(unmet: &mut u32, by: i32) -> bool {
    let before = *unmet;
    *unmet = before.wrapping_add_signed(by);
    (before == 0) != (*unmet == 0)
}
