//! What changes while a net runs; see [the layout](super::layout).

use super::layout::{BLOCK, Block, CHUNK, Change, Flip, Layout, OPEN, OpenFlip, PortChange, Span};
use super::net::PlaceId;
use super::ports::Ports;

/// The bits above bit `lane`.
#[inline]
pub(super) fn above(lane: usize) -> u64 {
    (!0 << lane) << 1
}

/// The marking of a net, as the truth of its conditions, and what has fired in this round.
#[derive(Clone, Debug)]
pub(super) struct State {
    /// In whole chunks.
    blocks: Box<[Block]>,
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

/// How a pass through one block ended.
#[derive(Clone, Copy, Debug)]
struct Pass {
    /// The transitions that are enabled.
    enabled: u64,
    /// The transitions that have not fired in this round.
    fresh: u64,
}

impl State {
    pub(super) fn new(blocks: Box<[Block]>, unmet: Box<[u32]>) -> Self {
        let mut state = Self {
            sets: vec![Sets::default(); blocks.len().div_ceil(BLOCK)].into(),
            blocks,
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
        self.unmet.copy_from_slice(&other.unmet);
        self.sets.copy_from_slice(&other.sets);
        self.any_used = other.any_used;
    }

    pub(super) fn is_marked(&self, layout: &Layout, place: PlaceId) -> bool {
        let place = &layout.places[place.index()];
        let transition = place.transition as usize;
        let block = &self.blocks[transition / BLOCK];
        let word = match place.slot {
            OPEN => block.open,
            slot => block.conditions[usize::from(slot)],
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

    /// Fires as far as `progress` allows, and uses it up. Each round begins behind the last that
    /// fired: first what is behind it in its block, then block by block, at last the rest of its
    /// block. Returns whether a transition is enabled.
    #[inline]
    pub(super) fn run(
        &mut self,
        layout: &Layout,
        ports: &mut Ports,
        progress: &mut Progress,
        mut on_fire: impl FnMut(usize),
    ) -> bool {
        let mut block = progress.last / BLOCK;
        if progress.firings == 0 || progress.rounds == 0 {
            self.look_at(block);
            return self.next_active(block).is_some();
        }
        loop {
            let mut among = above(progress.last % BLOCK);
            let enabled = loop {
                let pass = self.run_block(layout, ports, block, among, progress, &mut on_fire);
                if progress.firings == 0 {
                    break pass.enabled;
                }
                self.leave(block, pass);
                match self.next_active(block) {
                    Some(next) => block = next,
                    None => break pass.enabled,
                }
                among = !0;
            };
            if self.any_used {
                self.refresh_used();
            }
            progress.rounds -= 1;
            let any = enabled != 0 || self.next_active(block).is_some();
            if progress.firings == 0 || progress.rounds == 0 || !any {
                return any;
            }
            block = progress.last / BLOCK;
        }
    }

    /// Fires the ready transitions of `block` in order, beginning `among` these, until none behind
    /// the last is ready.
    #[inline]
    fn run_block(
        &mut self,
        layout: &Layout,
        ports: &mut Ports,
        block: usize,
        among: u64,
        progress: &mut Progress,
        mut on_fire: impl FnMut(usize),
    ) -> Pass {
        let firings = &layout.firings[block];
        let Block {
            conditions: [mut a, mut b, mut c, mut d],
            mut open,
            mut fresh,
        } = self.blocks[block];
        let mut enabled = a & b & c & d & open;
        let first = enabled & fresh & among;
        if first == 0 {
            return Pass { enabled, fresh };
        }
        let mut lane = first.trailing_zeros() as usize;
        let mut left = progress.firings;
        loop {
            let [flip_a, flip_b, flip_c, flip_d] = firings.flips[lane % BLOCK];
            a ^= flip_a;
            b ^= flip_b;
            c ^= flip_c;
            d ^= flip_d;
            fresh &= !(1 << lane);
            on_fire(block * BLOCK + lane);
            if firings.have_open >> lane & 1 == 1 {
                self.flip_open(&layout.first_open[block * BLOCK + lane]);
                open = self.blocks[block].open;
            }
            if firings.have_effects >> lane & 1 == 1 {
                self.apply_effects(layout, ports, block * BLOCK + lane);
                open = self.blocks[block].open;
            }
            enabled = a & b & c & d & open;
            left -= 1;
            if left == 0 {
                break;
            }
            // Those before are shifted out, and bit 0 has just fired.
            let behind = (enabled & fresh) >> lane;
            // Often the next transition follows. To test for it first lets the processor begin with
            // it before it knows.
            if behind & 2 != 0 {
                lane += 1;
            } else if behind != 0 {
                lane += behind.trailing_zeros() as usize;
            } else {
                break;
            }
        }
        self.blocks[block].conditions = [a, b, c, d];
        progress.firings = left;
        progress.last = block * BLOCK + lane;
        Pass { enabled, fresh }
    }

    /// Puts down what a pass through `block` has left behind.
    fn leave(&mut self, block: usize, pass: Pass) {
        self.set_active(block, pass.enabled & pass.fresh != 0);
        if pass.fresh != !0 {
            self.blocks[block].fresh = pass.fresh;
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

    #[inline(never)]
    fn apply_effects(&mut self, layout: &Layout, ports: &mut Ports, transition: usize) {
        let effects = &layout.effects[transition];
        self.change(layout, &effects.change);
        for change in effects.changes.of(&layout.changes) {
            self.change(layout, change);
        }
        for flip in effects.far.of(&layout.far) {
            self.flip_block(flip);
        }
        for change in effects.ports.of(&layout.port_changes) {
            match *change {
                PortChange::SourceEmptied(source) => ports.emptied(usize::from(source)),
                PortChange::SinkFilled(sink) => ports.filled(usize::from(sink)),
            }
        }
    }

    fn flip_block(&mut self, flip: &Flip) {
        let block = &mut self.blocks[flip.block as usize];
        for (bits, flips) in block.conditions.iter_mut().zip(&flip.bits) {
            *bits ^= flips;
        }
        self.look_at(flip.block as usize);
    }

    #[inline]
    fn change(&mut self, layout: &Layout, change: &Change) {
        self.flip_all_open(layout, change.open);
        for change in change.joints.of(&layout.joint_changes) {
            let joint = change.joint as usize;
            let before = self.unmet[joint];
            let after = before.wrapping_add_signed(change.unmet);
            self.unmet[joint] = after;
            if (before == 0) != (after == 0) {
                self.flip_all_open(layout, layout.joints[joint]);
            }
        }
    }

    #[inline]
    fn flip_all_open(&mut self, layout: &Layout, flips: Span) {
        for flip in flips.of(&layout.open_flips) {
            self.flip_open(flip);
        }
    }

    #[inline]
    fn flip_open(&mut self, flip: &OpenFlip) {
        let chunk = flip.chunk as usize;
        let blocks = &mut self.blocks[chunk * CHUNK..chunk * CHUNK + CHUNK];
        for (block, bits) in blocks.iter_mut().zip(&flip.bits) {
            block.open ^= bits;
        }
        self.sets[chunk / (BLOCK / CHUNK)].active |= flip.blocks;
    }

    fn is_ready(&self, block: usize) -> bool {
        let Block {
            conditions: [a, b, c, d],
            open,
            fresh,
        } = self.blocks[block];
        a & b & c & d & open & fresh != 0
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
