//! How a compiled net lies in memory.
//!
//! **Representation.** What a transition needs is a set of conditions: *this input is marked*, *that
//! output is empty*. The state of a net is the truth of these conditions, one bit each. Transitions
//! are grouped into blocks of 64, in the model's order, and bit t of a word belongs to the block's
//! t-th transition:
//!
//! | word | bit t is set while |
//! |---|---|
//! | `conditions[0..4]` | one condition of t on a local place each holds; without such a condition, always |
//! | `open` | the condition of t on a shared place holds, if it has just one |
//! | `fresh` | t has not fired in this round |
//!
//! The transitions that may fire are the AND of these words, but for those with several conditions
//! on shared places, of which each is looked at when its turn comes. There is no to-do list, so none
//! can repeat, overflow or lag. A place that changes flips its bit in every condition that mentions
//! it, whatever the direction; the flips of all places that one firing changes are combined at
//! compile time. So firing is a few XORs with constants.
//!
//! A place is *local* if few conditions mention it or all of them are in one block; its mark is
//! nowhere but in these conditions. Other places are *shared*: one resource of many processes. So
//! are those for which a transition with more than four conditions has no word left. Shared places
//! have their marks in a set of bits of their own, from which the word `open` of a block is made when
//! the net comes to that block. Only the block that runs keeps one up to date. Thus a firing costs
//! the same, however many transitions wait for a shared place.
//!
//! Blocks that may have something to fire are in a set, `active`, which is all that a search goes
//! through. What changes local conditions puts their block in or out. What marks a shared place puts
//! in all blocks that need it marked, what empties it those that need it empty, 64 at a time, and the
//! search puts out those that turn out to have nothing.
//!
//! **Bound.** A firing costs its arcs, and a word per 4,096 transitions of the net for each shared
//! place that it changes. A search looks in vain only at blocks where a transition waits for a shared
//! place that another one took before its turn came, or for the local places of a block that a
//! shared place put in; each such block is put out. There may be one in each block, after each
//! firing, so looks have a limit of their own, that grows with the budget of firings: then the
//! evaluation ends, and the next goes on behind the last block looked at, whatever happens in between,
//! so that all have their turn. A look costs the conditions of 64 transitions on shared places. So an
//! evaluation costs at most a constant plus its firings times another, in nets of any size.
//!
//! **Contract.** Between any two firings: (1) a bit in `conditions` equals its condition; (2) `open`
//! belongs to the block of the transition that fired last; (3) every other block with a transition
//! that may fire is active; (4) the bits of transitions that do not exist are 0 in `conditions[0]`.
//! Between any two evaluations all of `fresh` is set.

/// Conditions of a transition that have words of their own.
pub(super) const SLOTS: usize = 4;

/// Conditions that may mention a place in several blocks before it is shared.
pub(super) const LOCAL: u32 = 8;

/// Transitions per block, and blocks per word of a set of blocks.
pub(super) const BLOCK: usize = u64::BITS as usize;

/// One bit per transition of a block, for each of its local conditions.
pub(super) type Bits = [u64; SLOTS];

/// 64 transitions.
#[derive(Clone, Copy, Debug)]
#[repr(align(64))]
pub(super) struct Block {
    pub(super) conditions: Bits,
    pub(super) fresh: u64,
    // These never change; they are here because they are wanted together with the others.
    /// The transitions that have an entry in [`Layout::specials`].
    pub(super) special: u64,
    /// The special ones that have several conditions on shared places.
    pub(super) several: u64,
}

/// Bits in a word of a set.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct WordBits {
    /// Index of the word; a set has at most 2^16 / 64.
    pub(super) word: u16,
    pub(super) bits: u64,
}

/// Flips in the conditions of one block.
#[derive(Clone, Copy, Debug)]
pub(super) struct Flip {
    pub(super) block: u32,
    pub(super) bits: Bits,
}

/// A shared place, and the transitions of one block for which it is the only one.
#[derive(Clone, Copy, Debug)]
pub(super) struct Gate {
    pub(super) shared: u32,
    /// Those that are not open while it is empty, and those that are not while it is marked.
    pub(super) closed: [u64; 2],
}

impl Gate {
    pub(super) fn new(shared: u32) -> Self {
        Self {
            shared,
            closed: [0; 2],
        }
    }
}

/// What the marks of 64 shared places have to be.
#[derive(Clone, Copy, Debug)]
pub(super) struct Need {
    pub(super) word: u16,
    /// The places that matter.
    pub(super) care: u64,
    /// Their marks.
    pub(super) value: u64,
}

/// Some consecutive entries of an array.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Span {
    pub(super) start: u32,
    pub(super) end: u32,
}

impl Span {
    pub(super) fn contains(self, index: u32) -> bool {
        (self.start..self.end).contains(&index)
    }

    pub(super) fn of<T>(self, all: &[T]) -> &[T] {
        &all[self.start as usize..self.end as usize]
    }
}

/// What the firing of a special transition changes beside the conditions of its own block.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(32))]
pub(super) struct Special {
    /// Flips in `open`.
    pub(super) open: u64,
    /// Shared places that change.
    pub(super) marks: u64,
    /// The blocks that mention them.
    pub(super) wakes: u64,
    /// The words of `marks` and `wakes`.
    pub(super) marks_word: u16,
    pub(super) wakes_word: u16,
    /// Index of what else changes, or [`Special::NO_MORE`].
    pub(super) more: u32,
}

impl Special {
    pub(super) const NO_MORE: u32 = u32::MAX;

    pub(super) const NOTHING: Self = Self {
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
pub(super) struct More {
    /// Conditions in other blocks that change: [`Flip`]s.
    pub(super) far: Span,
    /// [`PortChange`]s.
    pub(super) ports: Span,
    /// Further shared places that change: [`WordBits`].
    pub(super) marks: Span,
    /// Further blocks that mention them: [`WordBits`].
    pub(super) wakes: Span,
}

/// A source or sink, an index into the net's list of them, changes.
#[derive(Clone, Copy, Debug)]
pub(super) enum PortChange {
    SourceEmptied(u16),
    SinkFilled(u16),
}

/// A place.
#[derive(Clone, Copy, Debug)]
pub(super) struct Place {
    /// Index of the first of its [`Position`]s, and the flags.
    first: u32,
    /// Behind the last position, or its index among the shared places.
    end: u32,
}

impl Place {
    const SHARED: u32 = 1 << 31;
    /// Several blocks mention it, or it is shared.
    const SEVERAL_BLOCKS: u32 = 1 << 30;
    /// Initially.
    const MARKED: u32 = 1 << 29;
    const FLAGS: u32 = Self::SHARED | Self::SEVERAL_BLOCKS | Self::MARKED;

    /// With room for positions from `first` on.
    #[inline]
    pub(super) fn local(first: u32, is_in_several_blocks: bool, is_marked: bool) -> Self {
        let flags = u32::from(is_in_several_blocks) << 30 | u32::from(is_marked) << 29;
        Self {
            first: first | flags,
            end: first,
        }
    }

    /// Makes it shared.
    pub(super) fn share(&mut self, index: u32) {
        self.first |= Self::SHARED | Self::SEVERAL_BLOCKS;
        self.end = index;
    }

    #[inline]
    pub(super) fn is_shared(&self) -> bool {
        self.first & Self::SHARED != 0
    }

    /// Whether several blocks mention it, or it is shared.
    #[inline]
    pub(super) fn is_in_several_blocks(&self) -> bool {
        self.first & Self::SEVERAL_BLOCKS != 0
    }

    /// Whether it is marked initially.
    #[inline]
    pub(super) fn is_marked(&self) -> bool {
        self.first & Self::MARKED != 0
    }

    /// The index of a shared place.
    #[inline]
    pub(super) fn as_shared(&self) -> Option<u32> {
        self.is_shared().then_some(self.end)
    }

    /// Where the next position of a local place goes.
    #[inline]
    pub(super) fn next_position(&mut self) -> usize {
        self.end += 1;
        self.end as usize - 1
    }

    /// The conditions on a local place, which are in one block or at most [`LOCAL`]; none of a shared
    /// one.
    #[inline]
    pub(super) fn positions<'a>(&self, all: &'a [Position]) -> &'a [Position] {
        if self.is_shared() {
            return &[];
        }
        &all[(self.first & !Self::FLAGS) as usize..self.end as usize]
    }
}

/// What a condition asks of its place, and what the transition does to it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Demand {
    /// It is marked, and is emptied.
    Marked,
    /// It is marked, and stays so.
    MarkedAndKept,
    /// It is empty, and is marked.
    Empty,
}

impl Demand {
    #[inline]
    pub(super) fn is_met(self, marked: bool) -> bool {
        marked == (self != Self::Empty)
    }

    /// Whether the place changes.
    #[inline]
    pub(super) fn changes(self) -> bool {
        self != Self::MarkedAndKept
    }
}

/// Where a condition on a local place is: from the lowest bit its transition, its word, whether the
/// place stays as it is, and whether it has to be empty.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Position(u32);

impl Position {
    #[inline]
    pub(super) fn new(transition: usize, slot: usize, demand: Demand) -> Self {
        let demand = u32::from(!demand.changes()) << 18 | u32::from(!demand.is_met(true)) << 19;
        Self(transition as u32 | (slot as u32) << 16 | demand)
    }

    #[inline]
    pub(super) fn transition(self) -> usize {
        self.0 as usize & 0xffff
    }

    #[inline]
    pub(super) fn block(self) -> usize {
        self.transition() / BLOCK
    }

    /// Its bit in the word.
    #[inline]
    pub(super) fn bit(self) -> u64 {
        1 << (self.0 as usize % BLOCK)
    }

    #[inline]
    pub(super) fn slot(self) -> usize {
        (self.0 >> 16) as usize % SLOTS
    }

    #[inline]
    pub(super) fn changes(self) -> bool {
        self.0 >> 18 & 1 == 0
    }

    #[inline]
    pub(super) fn when_marked(self) -> bool {
        self.0 >> 19 & 1 == 0
    }
}

/// The constant tables of a net.
#[derive(Clone, Debug)]
pub(super) struct Layout {
    pub(super) transitions: usize,
    /// By block and transition: the flips of a firing in its own block.
    pub(super) own: Box<[[Bits; BLOCK]]>,
    /// By transition, up to the last special one.
    pub(super) specials: Box<[Special]>,
    pub(super) more: Box<[More]>,
    /// By transition, up to the last with several conditions on shared places: its [`Need`]s.
    pub(super) needs_of: Box<[Span]>,
    pub(super) needs: Box<[Need]>,
    pub(super) far: Box<[Flip]>,
    pub(super) port_changes: Box<[PortChange]>,
    pub(super) word_bits: Box<[WordBits]>,
    /// By block: its [`Gate`]s.
    pub(super) gates_of: Box<[Span]>,
    pub(super) gates: Box<[Gate]>,
    pub(super) places: Box<[Place]>,
    /// Of all local places.
    pub(super) positions: Box<[Position]>,
    /// By shared place: the set of the blocks that may have more to fire when it is emptied, and
    /// of those that may when it is marked.
    pub(super) users: Box<[u64]>,
}

/// Words of a set of blocks.
pub(super) fn set_words(blocks: usize) -> usize {
    blocks.div_ceil(BLOCK)
}

/// The set of the blocks that have a condition which holds while the shared place is marked, or
/// while it is empty.
#[inline]
pub(super) fn users_of(all: &[u64], blocks: usize, shared: u32, when_marked: bool) -> &[u64] {
    let words = set_words(blocks);
    let set = 2 * shared as usize + usize::from(when_marked);
    &all[set * words..][..words]
}
