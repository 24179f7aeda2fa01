//! What changes while a net runs; see [the layout](super::layout).

use super::layout::{BLOCK, Block, Effect, Flip, Layout, Row, Where};
use super::net::PlaceId;
use super::ports::Ports;

/// The bits above bit `lane`.
#[inline]
pub(super) fn above(lane: usize) -> u64 {
    (!0 << lane) << 1
}

/// What a pass through one block did.
#[derive(Clone, Copy, Debug)]
pub(super) struct Run {
    pub(super) fired: u32,
    /// The transition that fired last, if any fired.
    pub(super) last: usize,
}

/// The marking of a net, as the truth of its conditions, and what has fired in this round.
#[derive(Clone, Debug)]
pub(super) struct State {
    blocks: Box<[Block]>,
    /// By joint: how many of its conditions do not hold.
    counts: Box<[u32]>,
    /// By shared place: whether it is marked.
    marked: Box<[bool]>,
    /// A bit per block, set if it has ready transitions; also set if a row has touched it and
    /// nobody has looked at it since.
    active: Box<[u64]>,
    /// A bit per block, set if a transition of it has fired in this round.
    used: Box<[u64]>,
}

impl State {
    /// With all places empty.
    pub(super) fn new(layout: &Layout) -> Self {
        let words = layout.empty_blocks.len().div_ceil(BLOCK);
        let mut state = Self {
            blocks: layout.empty_blocks.clone(),
            counts: layout.empty_counts.clone(),
            marked: vec![false; layout.shared.len()].into(),
            active: vec![0; words].into(),
            used: vec![0; words].into(),
        };
        for block in 0..state.blocks.len() {
            state.look_at(block);
        }
        state
    }

    /// Makes this a copy of a state of the same net.
    pub(super) fn copy_from(&mut self, other: &Self) {
        self.blocks.copy_from_slice(&other.blocks);
        self.counts.copy_from_slice(&other.counts);
        self.marked.copy_from_slice(&other.marked);
        self.active.copy_from_slice(&other.active);
        self.used.copy_from_slice(&other.used);
    }

    pub(super) fn is_marked(&self, layout: &Layout, place: PlaceId) -> bool {
        match layout.places[place.index()] {
            Where::Shared(shared) => self.marked[shared as usize],
            Where::Local {
                transition,
                slot,
                when_marked,
            } => {
                let transition = transition as usize;
                let word = self.blocks[transition / BLOCK].conditions[usize::from(slot)];
                (word >> (transition % BLOCK) & 1 == 1) == when_marked
            }
        }
    }

    /// Marks a place that is empty or empties one that is marked.
    pub(super) fn flip(&mut self, layout: &Layout, place: PlaceId) {
        if let Where::Shared(shared) = layout.places[place.index()] {
            self.set_shared(layout, shared as usize, !self.marked[shared as usize]);
        }
        for flip in layout.flips.of(place.index()) {
            self.flip_block(flip);
        }
    }

    /// Fires ready transitions of `block` among `among`, in order and then those behind, until none
    /// of them is ready any more or `limit` (not 0) have fired.
    #[inline]
    pub(super) fn run_block(
        &mut self,
        layout: &Layout,
        ports: &mut Ports,
        block: usize,
        among: u64,
        limit: u32,
        mut on_fire: impl FnMut(usize),
    ) -> Run {
        let own = &layout.own[block];
        let has_effects = layout.has_effects[block];
        let Block {
            mut conditions,
            mut open,
            mut fresh,
        } = self.blocks[block];
        let mut fired = 0;
        let mut lane = 0;
        let [a, b, c, d] = conditions;
        let mut ready = a & b & c & d & open & fresh;
        let mut next = ready & among;
        while next != 0 {
            lane = next.trailing_zeros() as usize;
            loop {
                fresh &= !(1 << lane);
                for (bits, flips) in conditions.iter_mut().zip(&own[lane]) {
                    *bits ^= flips;
                }
                on_fire(block * BLOCK + lane);
                fired += 1;
                if has_effects >> lane & 1 == 1 {
                    self.apply_effects(layout, ports, block * BLOCK + lane);
                    open = self.blocks[block].open;
                }
                let [a, b, c, d] = conditions;
                ready = a & b & c & d & open & fresh;
                if fired == limit {
                    break;
                }
                // Often the next transition follows. To test for it first lets the processor begin
                // with it before it knows.
                if lane + 1 < BLOCK && ready >> (lane + 1) & 1 == 1 {
                    lane += 1;
                } else {
                    break;
                }
            }
            next = if fired == limit {
                0
            } else {
                ready & above(lane)
            };
        }
        if fired > 0 {
            let block = &mut self.blocks[block];
            block.conditions = conditions;
            block.fresh = fresh;
        }
        let (word, bit) = (block / BLOCK, 1 << (block % BLOCK));
        set(&mut self.active[word], bit, ready != 0);
        set(&mut self.used[word], bit, fresh != !0);
        Run {
            fired,
            last: block * BLOCK + lane,
        }
    }

    /// The next block behind `block`, wrapping around to it, that has ready transitions.
    pub(super) fn next_ready(&mut self, block: usize) -> Option<usize> {
        let words = self.active.len();
        let first = block / BLOCK;
        let mut among = above(block % BLOCK);
        for step in 0..=words {
            let word = if first + step < words {
                first + step
            } else {
                first + step - words
            };
            loop {
                let active = self.active[word] & among;
                if active == 0 {
                    break;
                }
                let lane = active.trailing_zeros() as usize;
                if self.blocks[word * BLOCK + lane].ready() != 0 {
                    return Some(word * BLOCK + lane);
                }
                self.active[word] &= !(1 << lane);
            }
            among = !0;
        }
        None
    }

    /// Lets every transition fire again; costs what has fired.
    pub(super) fn begin_round(&mut self) {
        for word in 0..self.used.len() {
            let mut used = std::mem::take(&mut self.used[word]);
            while used != 0 {
                let block = word * BLOCK + used.trailing_zeros() as usize;
                used &= used - 1;
                self.blocks[block].fresh = !0;
                self.look_at(block);
            }
        }
    }

    fn apply_effects(&mut self, layout: &Layout, ports: &mut Ports, transition: usize) {
        for &effect in layout.effects.of(transition) {
            match effect {
                Effect::Far(flip) => self.flip_block(&layout.far[flip as usize]),
                Effect::Shared(shared, marked) => {
                    self.set_shared(layout, shared as usize, marked);
                }
                Effect::SourceEmptied(source) => ports.emptied(usize::from(source)),
                Effect::SinkFilled(sink) => ports.filled(usize::from(sink)),
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

    /// The place changes to `marked`.
    fn set_shared(&mut self, layout: &Layout, shared: usize, marked: bool) {
        self.marked[shared] = marked;
        let shared = &layout.shared[shared];
        self.apply(&shared.row);
        for &(joint, when_marked) in &shared.joints {
            let count = &mut self.counts[joint as usize];
            let crosses = if when_marked == marked {
                *count -= 1;
                *count == 0
            } else {
                *count += 1;
                *count == 1
            };
            if crosses {
                self.apply(&layout.joints[joint as usize].row);
            }
        }
    }

    fn apply(&mut self, row: &Row) {
        for &(block, bits) in &row.flips {
            self.blocks[block as usize].open ^= bits;
        }
        for &(word, blocks) in &row.blocks {
            self.active[word as usize] |= blocks;
        }
    }

    fn look_at(&mut self, block: usize) {
        let ready = self.blocks[block].ready() != 0;
        set(&mut self.active[block / BLOCK], 1 << (block % BLOCK), ready);
    }
}

fn set(word: &mut u64, bit: u64, value: bool) {
    *word = (*word & !bit) | if value { bit } else { 0 };
}
