//! How a compiled net lies in memory.
//!
//! **Representation.** What a transition needs is a set of conditions: *this input is marked*, *that
//! output is empty*. The state of a net is the truth of these conditions, one bit each; there is no
//! marking beside it. Transitions are grouped into blocks of 64, in the model's order, and bit t of
//! a word belongs to the block's t-th transition:
//!
//! | word | bit t is set while |
//! |---|---|
//! | `conditions[0..4]` | one condition of t each holds; without such a condition, always |
//! | `open` | all further conditions of t hold |
//! | `fresh` | t has not fired in this round |
//!
//! The transitions that may fire are the AND of these words. That is exact at any time, so a to-do
//! list is not needed, and none can repeat, overflow or lag. A place that changes flips its bit in
//! every condition that mentions it, whatever the direction. The flips of all places that one firing
//! changes are combined at compile time, so that firing is a few XORs with constants.
//!
//! A place is *shared* if more than [`LOCAL`] conditions in several blocks mention it (one resource
//! of many processes), or if a transition with more than four conditions has no word left for it.
//! Conditions on shared places are in `open`. A transition with one shared condition has it there as
//! it is. One with several is a member of a *joint*, which counts how many of its conditions do not
//! hold; the bits of its members change when the count reaches or leaves zero. The flips of a shared
//! place in `open` are stored once for all firings that change it, so the tables grow linearly with
//! the arcs.
//!
//! **Contract.** At any time: (1) a bit in `conditions` equals its condition; (2) the count of a
//! joint equals the number of its conditions that do not hold; (3) a bit in `open` equals the
//! conjunction of its transition's shared conditions; (4) the bits of transitions that do not exist
//! are 0 in `conditions[0]`. A shared place that only joints mention has the `open` bit of such a
//! transition, so that every place can be read from some bit.

/// Conditions of a transition that have bits of their own.
pub(super) const SLOTS: usize = 4;

/// Conditions that may mention a place in several blocks before it is shared.
pub(super) const LOCAL: u32 = 8;

/// Transitions per block.
pub(super) const BLOCK: usize = u64::BITS as usize;

/// Blocks whose `open` words a row flips at once.
pub(super) const CHUNK: usize = 8;

/// One bit per transition of a block, for each of its conditions.
pub(super) type Bits = [u64; SLOTS];

/// The state of 64 transitions, but for their `open` word; those lie together.
#[derive(Clone, Copy, Debug)]
#[repr(align(64))]
pub(super) struct Block {
    pub(super) conditions: Bits,
    pub(super) fresh: u64,
    /// The transitions that change more than the conditions of this block. It never changes, and is
    /// here because it is wanted together with the others.
    pub(super) special: u64,
}

/// Flips in the conditions of one block.
#[derive(Clone, Copy, Debug)]
pub(super) struct Flip {
    pub(super) block: u32,
    pub(super) bits: Bits,
}

/// Flips in the `open` words of [`CHUNK`] blocks.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct OpenFlip {
    /// Of blocks.
    pub(super) chunk: u32,
    /// The blocks that change, as a set of blocks has them.
    pub(super) blocks: u64,
    pub(super) bits: [u64; CHUNK],
}

/// Some consecutive entries of an array.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Span {
    pub(super) start: u32,
    pub(super) end: u32,
}

impl Span {
    pub(super) fn is_empty(self) -> bool {
        self.start == self.end
    }

    pub(super) fn of<T>(self, all: &[T]) -> &[T] {
        &all[self.start as usize..self.end as usize]
    }
}

/// The word of a shared condition, instead of a number below [`SLOTS`].
pub(super) const OPEN: u8 = SLOTS as u8;

/// A place; either it is shared, or it has flips in `conditions`.
#[derive(Clone, Copy, Debug)]
pub(super) struct Place {
    /// Index among the shared places, or [`Place::NOT_SHARED`].
    pub(super) shared: u32,
    /// Index of its first flip.
    pub(super) first_flip: u32,
    /// How many flips it has, one per block that mentions it.
    pub(super) flips: u32,
    /// A transition with a condition on it, the word of that condition, and whether the condition
    /// holds while the place is marked: from these the marking is read.
    pub(super) transition: u32,
    pub(super) slot: u8,
    pub(super) when_marked: bool,
}

impl Place {
    pub(super) const NOT_SHARED: u32 = u32::MAX;

    pub(super) fn is_shared(&self) -> bool {
        self.shared != Self::NOT_SHARED
    }
}

/// What happens when shared places change.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Change {
    /// [`OpenFlip`]s.
    pub(super) open: Span,
    /// [`JointChange`]s.
    pub(super) joints: Span,
}

/// So many more conditions of a joint do not hold, or fewer if negative.
#[derive(Clone, Copy, Debug)]
pub(super) struct JointChange {
    pub(super) joint: u32,
    pub(super) unmet: i32,
}

/// A source or sink, an index into the net's list of them, changes.
#[derive(Clone, Copy, Debug)]
pub(super) enum PortChange {
    SourceEmptied(u16),
    SinkFilled(u16),
}

/// What the firing of a special transition changes beside the conditions of its own block.
#[derive(Clone, Copy, Debug)]
pub(super) struct Special {
    pub(super) open: OpenFlip,
    /// Its joint may be [`Special::NONE`].
    pub(super) joint: JointChange,
    /// Index of further effects, or [`Special::NONE`].
    pub(super) more: u32,
}

impl Special {
    pub(super) const NONE: u32 = u32::MAX;

    pub(super) const NOTHING: Self = Self {
        open: OpenFlip {
            chunk: 0,
            blocks: 0,
            bits: [0; CHUNK],
        },
        joint: JointChange {
            joint: Self::NONE,
            unmet: 0,
        },
        more: Self::NONE,
    };
}

/// Effects that most transitions do not have.
#[derive(Clone, Copy, Debug)]
pub(super) struct Effects {
    /// Conditions in other blocks: [`Flip`]s.
    pub(super) far: Span,
    /// [`PortChange`]s.
    pub(super) ports: Span,
    /// What is left of the first [`Change`] of shared places.
    pub(super) change: Change,
    /// Further ones.
    pub(super) changes: Span,
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
    pub(super) changes: Box<[Change]>,
    pub(super) far: Box<[Flip]>,
    pub(super) port_changes: Box<[PortChange]>,
    pub(super) open_flips: Box<[OpenFlip]>,
    pub(super) joint_changes: Box<[JointChange]>,
    /// By joint: the [`OpenFlip`]s of its members.
    pub(super) joints: Box<[Span]>,
    pub(super) places: Box<[Place]>,
    /// Of all places that are not shared.
    pub(super) flips: Box<[Flip]>,
    /// By shared place: what happens when it is emptied and when it is marked.
    pub(super) shared: Box<[[Change; 2]]>,
}

impl Layout {
    pub(super) fn flips_of(&self, place: &Place) -> &[Flip] {
        let first = place.first_flip as usize;
        &self.flips[first..first + place.flips as usize]
    }
}
