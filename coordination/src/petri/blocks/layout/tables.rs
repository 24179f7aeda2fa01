//! The tables of a compiled net; see [blocks](crate::petri::blocks).

use alloc::boxed::Box;

use crate::petri::demand::Demand;
use crate::petri::ports::PortChange;
use crate::petri::span::Span;

/// Conditions of a transition that have words of their own.
pub(in crate::petri) const SLOTS: usize = 4;

/// Conditions that may mention a place in several blocks before it is shared.
pub(in crate::petri) const LOCAL: u32 = 8;

/// Transitions per block, and blocks per word of a set of blocks.
pub(in crate::petri) const BLOCK: usize = u64::BITS as usize;

/// One bit per transition of a block, for each of its local conditions.
pub(in crate::petri) type Bits = [u64; SLOTS];

/// 64 transitions.
#[derive(Clone, Copy, Debug)]
#[repr(align(64))]
pub(in crate::petri) struct Block {
    pub(in crate::petri) conditions: Bits,
    pub(in crate::petri) fresh: u64,
    // These never change; they are here because they are wanted together with the others.
    /// The transitions that have an entry in [`Layout::specials`].
    pub(in crate::petri) special: u64,
    /// The special ones that have several conditions on shared places.
    pub(in crate::petri) several: u64,
}

/// Bits in a word of a set.
#[derive(Clone, Copy, Debug, Default)]
pub(in crate::petri) struct WordBits {
    /// Index of the word; a set has at most 2^16 / 64.
    pub(in crate::petri) word: u16,
    pub(in crate::petri) bits: u64,
}

/// Flips in the conditions of one block.
#[derive(Clone, Copy, Debug)]
pub(in crate::petri) struct Flip {
    pub(in crate::petri) block: u32,
    pub(in crate::petri) bits: Bits,
}

/// A shared place, and the transitions of one block for which it is the only one.
#[derive(Clone, Copy, Debug)]
pub(in crate::petri) struct Gate {
    pub(in crate::petri) shared: u32,
    /// Those that are not open while it is empty, and those that are not while it is marked.
    pub(in crate::petri) closed: [u64; 2],
}

impl Gate {
    pub(in crate::petri) fn new(shared: u32) -> Self {
        Self {
            shared,
            closed: [0; 2],
        }
    }
}

/// What the marks of 64 shared places have to be.
#[derive(Clone, Copy, Debug)]
pub(in crate::petri) struct Need {
    pub(in crate::petri) word: u16,
    /// The places that matter.
    pub(in crate::petri) care: u64,
    /// Their marks.
    pub(in crate::petri) value: u64,
}

/// What the firing of a special transition changes beside the conditions of its own block.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(32))]
pub(in crate::petri) struct Special {
    /// Flips in `open`.
    pub(in crate::petri) open: u64,
    /// Shared places that change.
    pub(in crate::petri) marks: u64,
    /// The blocks that mention them.
    pub(in crate::petri) wakes: u64,
    /// The words of `marks` and `wakes`.
    pub(in crate::petri) marks_word: u16,
    pub(in crate::petri) wakes_word: u16,
    /// Index of what else changes, or [`Special::NO_MORE`].
    pub(in crate::petri) more: u32,
}

impl Special {
    pub(in crate::petri) const NO_MORE: u32 = u32::MAX;

    pub(in crate::petri) const NOTHING: Self = Self {
        open: 0,
        marks: 0,
        wakes: 0,
        marks_word: 0,
        wakes_word: 0,
        more: Self::NO_MORE,
    };
}

/// What most firings do not change.
#[derive(Clone, Copy, Debug)]
pub(in crate::petri) struct More {
    /// Conditions in other blocks that change: [`Flip`]s.
    pub(in crate::petri) far: Span,
    /// [`PortChange`]s.
    pub(in crate::petri) ports: Span,
    /// Further shared places that change: [`WordBits`].
    pub(in crate::petri) marks: Span,
    /// Further blocks that mention them: [`WordBits`].
    pub(in crate::petri) wakes: Span,
}

/// A place.
#[derive(Clone, Copy, Debug)]
pub(in crate::petri) struct PlaceEntry {
    /// Index of the first of its [`Position`]s, and the flags.
    first: u32,
    /// Behind the last position, or its index among the shared places.
    end: u32,
}

impl PlaceEntry {
    const SHARED: u32 = 1 << 31;
    /// Several blocks mention it, or it is shared.
    const SEVERAL_BLOCKS: u32 = 1 << 30;
    /// Initially.
    const MARKED: u32 = 1 << 29;
    const FLAGS: u32 = Self::SHARED | Self::SEVERAL_BLOCKS | Self::MARKED;

    /// With room for positions from `first` on.
    #[inline]
    pub(in crate::petri) fn local(first: u32, is_in_several_blocks: bool, is_marked: bool) -> Self {
        let flags = u32::from(is_in_several_blocks) << 30 | u32::from(is_marked) << 29;
        Self {
            first: first | flags,
            end: first,
        }
    }

    /// Makes it shared.
    pub(in crate::petri) fn share(&mut self, index: u32) {
        self.first |= Self::SHARED | Self::SEVERAL_BLOCKS;
        self.end = index;
    }

    #[inline]
    pub(in crate::petri) fn is_shared(&self) -> bool {
        self.first & Self::SHARED != 0
    }

    /// Whether several blocks mention it, or it is shared.
    #[inline]
    pub(in crate::petri) fn is_in_several_blocks(&self) -> bool {
        self.first & Self::SEVERAL_BLOCKS != 0
    }

    /// Whether it is marked initially.
    #[inline]
    pub(in crate::petri) fn is_marked(&self) -> bool {
        self.first & Self::MARKED != 0
    }

    /// The index of a shared place.
    #[inline]
    pub(in crate::petri) fn as_shared(&self) -> Option<u32> {
        self.is_shared().then_some(self.end)
    }

    /// Where the next position of a local place goes.
    #[inline]
    pub(in crate::petri) fn next_position(&mut self) -> usize {
        self.end += 1;
        self.end as usize - 1
    }

    /// The conditions on a local place, which are in one block or at most [`LOCAL`]; none of a shared
    /// one.
    #[inline]
    pub(in crate::petri) fn positions<'a>(&self, all: &'a [Position]) -> &'a [Position] {
        if self.is_shared() {
            return &[];
        }
        &all[(self.first & !Self::FLAGS) as usize..self.end as usize]
    }
}

/// Where a condition on a local place is: from the lowest bit its transition, its word, whether the
/// place stays as it is, and whether it has to be empty.
#[derive(Clone, Copy, Debug, Default)]
pub(in crate::petri) struct Position(u32);

impl Position {
    #[inline]
    pub(in crate::petri) fn new(transition: usize, slot: usize, demand: Demand) -> Self {
        let demand = u32::from(!demand.changes()) << 18 | u32::from(!demand.is_met(true)) << 19;
        Self(transition as u32 | (slot as u32) << 16 | demand)
    }

    #[inline]
    pub(in crate::petri) fn transition(self) -> usize {
        self.0 as usize & 0xffff
    }

    #[inline]
    pub(in crate::petri) fn block(self) -> usize {
        self.transition() / BLOCK
    }

    /// Its bit in the word.
    #[inline]
    pub(in crate::petri) fn bit(self) -> u64 {
        1 << (self.0 as usize % BLOCK)
    }

    #[inline]
    pub(in crate::petri) fn slot(self) -> usize {
        (self.0 >> 16) as usize % SLOTS
    }

    #[inline]
    pub(in crate::petri) fn changes(self) -> bool {
        self.0 >> 18 & 1 == 0
    }

    #[inline]
    pub(in crate::petri) fn when_marked(self) -> bool {
        self.0 >> 19 & 1 == 0
    }
}

/// The constant tables of a net.
#[derive(Clone, Debug)]
pub(in crate::petri) struct Layout {
    pub(in crate::petri) transitions: usize,
    /// By block and transition: the flips of a firing in its own block.
    pub(in crate::petri) own: Box<[[Bits; BLOCK]]>,
    /// By transition, up to the last special one.
    pub(in crate::petri) specials: Box<[Special]>,
    pub(in crate::petri) more: Box<[More]>,
    /// By transition, up to the last with several conditions on shared places: its [`Need`]s.
    pub(in crate::petri) needs_of: Box<[Span]>,
    pub(in crate::petri) needs: Box<[Need]>,
    pub(in crate::petri) far: Box<[Flip]>,
    pub(in crate::petri) port_changes: Box<[PortChange]>,
    pub(in crate::petri) word_bits: Box<[WordBits]>,
    /// By block: its [`Gate`]s.
    pub(in crate::petri) gates_of: Box<[Span]>,
    pub(in crate::petri) gates: Box<[Gate]>,
    pub(in crate::petri) places: Box<[PlaceEntry]>,
    /// Of all local places.
    pub(in crate::petri) positions: Box<[Position]>,
    /// By shared place: the set of the blocks that may have more to fire when it is emptied, and
    /// of those that may when it is marked.
    pub(in crate::petri) users: Box<[u64]>,
}

/// Words of a set of blocks.
pub(in crate::petri) fn set_words(blocks: usize) -> usize {
    blocks.div_ceil(BLOCK)
}

/// The set of the blocks that have a condition which holds while the shared place is marked, or
/// while it is empty.
#[inline]
pub(in crate::petri) fn users_of(
    all: &[u64],
    blocks: usize,
    shared: u32,
    when_marked: bool,
) -> &[u64] {
    let words = set_words(blocks);
    let set = 2 * shared as usize + usize::from(when_marked);
    &all[set * words..][..words]
}
