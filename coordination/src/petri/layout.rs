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
//! through. What changes local conditions puts their block in or out. What changes a shared place
//! puts in all blocks that mention it, 64 at a time, and the search puts out those that turn out to
//! have nothing.
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
    /// Index of the word.
    pub(super) word: u32,
    pub(super) bits: u64,
}

/// Flips in the conditions of one block.
#[derive(Clone, Copy, Debug)]
pub(super) struct Flip {
    pub(super) block: u32,
    /// Index of another flip of the same place, in a block before, or [`Flip::NONE`].
    pub(super) before: u32,
    pub(super) bits: Bits,
}

impl Flip {
    pub(super) const NONE: u32 = u32::MAX;
}

/// A shared place, and the transitions of one block for which it is the only one.
#[derive(Clone, Copy, Debug)]
pub(super) struct Gate {
    pub(super) shared: u32,
    /// Those that are not open while it is empty, and those that are not while it is marked.
    pub(super) closed: [u64; 2],
}

/// What the marks of 64 shared places have to be.
#[derive(Clone, Copy, Debug)]
pub(super) struct Need {
    pub(super) word: u32,
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

/// What a special transition needs, and what its firing changes, beside the conditions of its own
/// block.
#[derive(Clone, Copy, Debug)]
pub(super) struct Special {
    /// Flips in `open`.
    pub(super) open: u64,
    /// Shared places that change.
    pub(super) marks: WordBits,
    /// The blocks that mention them.
    pub(super) wakes: WordBits,
    /// Index of further effects, or [`Special::NO_MORE`].
    pub(super) more: u32,
    /// [`Need`]s, if it has several conditions on shared places.
    pub(super) needs: Span,
}

impl Special {
    pub(super) const NO_MORE: u32 = u32::MAX;

    pub(super) const NOTHING: Self = Self {
        open: 0,
        marks: WordBits { word: 0, bits: 0 },
        wakes: WordBits { word: 0, bits: 0 },
        more: Self::NO_MORE,
        needs: Span { start: 0, end: 0 },
    };
}

/// Effects that most special transitions do not have.
#[derive(Clone, Copy, Debug)]
pub(super) struct Effects {
    /// Conditions in other blocks: [`Flip`]s.
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

/// A place; either it is local and has flips, or it is shared.
#[derive(Clone, Copy, Debug)]
pub(super) struct Place {
    /// Index of the latest of its flips, or among the shared places.
    index: u32,
    is_shared: bool,
    /// Of a local place, a condition from which its mark is read.
    pub(super) witness: Witness,
}

/// A condition.
#[derive(Clone, Copy, Debug)]
pub(super) struct Witness {
    pub(super) transition: u16,
    /// Its word.
    pub(super) slot: u8,
    /// It holds while the place is marked, else while it is empty.
    pub(super) when_marked: bool,
}

impl Place {
    /// Without flips.
    pub(super) const LOCAL: Self = Self {
        index: Flip::NONE,
        is_shared: false,
        witness: Witness {
            transition: 0,
            slot: 0,
            when_marked: false,
        },
    };

    pub(super) fn shared(index: u32) -> Self {
        Self {
            index,
            is_shared: true,
            ..Self::LOCAL
        }
    }

    pub(super) fn is_shared(&self) -> bool {
        self.is_shared
    }

    /// The index of a shared place.
    pub(super) fn as_shared(&self) -> Option<u32> {
        self.is_shared.then_some(self.index)
    }

    /// Adds a bit, behind all others, to the flips of a local place; whether that took a new flip.
    #[inline]
    pub(super) fn add_flip(
        &mut self,
        all: &mut Vec<Flip>,
        block: u32,
        slot: usize,
        bit: u64,
    ) -> bool {
        let latest = all.get_mut(self.index as usize);
        if let Some(latest) = latest.filter(|latest| latest.block == block) {
            latest.bits[slot] |= bit;
            return false;
        }
        let mut bits = [0; SLOTS];
        bits[slot] = bit;
        let before = self.index;
        self.index = all.len() as u32;
        all.push(Flip {
            block,
            before,
            bits,
        });
        true
    }

    /// The flips of a local place.
    #[inline]
    pub(super) fn flips<'a>(&self, all: &'a [Flip]) -> impl Iterator<Item = &'a Flip> {
        let mut index = if self.is_shared {
            Flip::NONE
        } else {
            self.index
        };
        std::iter::from_fn(move || {
            let flip = all.get(index as usize)?;
            index = flip.before;
            Some(flip)
        })
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
    pub(super) effects: Box<[Effects]>,
    pub(super) needs: Box<[Need]>,
    pub(super) far: Box<[Flip]>,
    pub(super) port_changes: Box<[PortChange]>,
    pub(super) word_bits: Box<[WordBits]>,
    /// By block: its [`Gate`]s.
    pub(super) gates_of: Box<[Span]>,
    pub(super) gates: Box<[Gate]>,
    pub(super) places: Box<[Place]>,
    /// Of all local places.
    pub(super) flips: Vec<Flip>,
    /// By shared place: the set of the blocks that mention it.
    pub(super) users: Box<[u64]>,
}
