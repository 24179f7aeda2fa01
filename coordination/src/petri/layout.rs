//! How a compiled net lies in memory.
//!
//! **Representation.** What a transition needs is a set of conditions: *this input is marked*, *that
//! output is empty*. The state of a net is the truth of these conditions, one bit each, and nothing
//! else: there is no marking beside it. Transitions are grouped by 64, in the model's order. A
//! [`Block`] is one cache line with seven words; bit t of a word belongs to the block's t-th
//! transition:
//!
//! | word | bit t is set while |
//! |---|---|
//! | `conditions[0..4]` | one condition of t each holds; without such a condition, always |
//! | `open` | all further conditions of t hold |
//! | `fresh` | t has not fired in this round |
//!
//! The transitions that may fire are therefore the AND of these words: exact at any time, so no
//! to-do list can hold a place twice or too long. A place that changes flips its bit in every
//! condition that mentions it, whatever the direction; the flips of all places that one firing
//! changes are combined at compile time, so that firing is a few XORs with constants.
//!
//! A place is *local* if at most [`LOCAL_BLOCKS`] blocks mention it, which is the rule; its
//! conditions are in `conditions`. Any other place is *shared* (one resource of many processes), and
//! so is one that a transition with more than four conditions cannot keep. Shared places act on
//! `open`, through [`Row`]s of flips that all transitions have in common, so that the tables grow
//! linearly with the arcs. A transition with one shared condition has its bit in the row of that
//! place. One with several is a member of a [`Joint`], which counts how many of its conditions do
//! not hold, and whose row is applied when the count leaves or reaches zero.
//!
//! **Contract.** For every reachable state: (1) a bit of `conditions` equals its condition; (2) the
//! count of a joint equals the number of its conditions that do not hold; (3) an `open` bit equals
//! the conjunction of its transition's shared conditions; (4) bits of transitions that do not exist
//! are 0 in `conditions[0]`.

/// Conditions that a transition has as bits of its own.
pub(super) const SLOTS: usize = 4;

/// Blocks that may mention a local place.
pub(super) const LOCAL_BLOCKS: u32 = 2;

/// Transitions per block.
pub(super) const BLOCK: usize = u64::BITS as usize;

/// One bit per transition, for each of the conditions.
pub(super) type Bits = [u64; SLOTS];

/// The state of 64 transitions.
#[derive(Clone, Copy, Debug)]
#[repr(align(64))]
pub(super) struct Block {
    pub(super) conditions: Bits,
    pub(super) open: u64,
    pub(super) fresh: u64,
}

impl Block {
    /// The transitions that are enabled and have not fired in this round.
    pub(super) fn ready(&self) -> u64 {
        let [a, b, c, d] = self.conditions;
        a & b & c & d & self.open & self.fresh
    }
}

/// Flips in the conditions of one block.
#[derive(Clone, Copy, Debug)]
pub(super) struct Flip {
    pub(super) block: u32,
    pub(super) bits: Bits,
}

/// Flips in the `open` words of several blocks.
#[derive(Clone, Debug, Default)]
pub(super) struct Row {
    /// Block and bits, by block.
    pub(super) flips: Vec<(u32, u64)>,
    /// The blocks of `flips` as a set of bits: index of the word, word.
    pub(super) blocks: Vec<(u32, u64)>,
}

/// A shared place, or rather what depends on it.
#[derive(Clone, Debug, Default)]
pub(super) struct Shared {
    pub(super) row: Row,
    /// The joints with a condition on this place, and whether that condition is to be marked.
    pub(super) joints: Vec<(u32, bool)>,
}

/// A set of conditions on shared places; its members are open while all of them hold.
#[derive(Clone, Debug, Default)]
pub(super) struct Joint {
    pub(super) row: Row,
}

/// Where the conditions on a place are.
#[derive(Clone, Copy, Debug)]
pub(super) enum Where {
    /// In blocks; `slot` and `transition` name one of its conditions, which holds while the place
    /// is marked if `when_marked`, else while it is empty.
    Local {
        transition: u32,
        slot: u8,
        when_marked: bool,
    },
    /// In `shared`, at this index.
    Shared(u32),
}

/// What a firing changes beside the conditions of its own block.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Effect {
    /// Conditions in another block: index into `far`.
    Far(u32),
    /// This shared place becomes marked or empty.
    Shared(u32, bool),
    /// This source, an index into the net's sources, becomes empty.
    SourceEmptied(u16),
    /// This sink, an index into the net's sinks, becomes full.
    SinkFilled(u16),
}

/// Slices of one array, one per index.
#[derive(Clone, Debug)]
pub(super) struct Ranges<T> {
    /// One more than there are slices.
    pub(super) starts: Box<[u32]>,
    pub(super) items: Box<[T]>,
}

impl<T> Ranges<T> {
    pub(super) fn of(&self, index: usize) -> &[T] {
        &self.items[self.starts[index] as usize..self.starts[index + 1] as usize]
    }
}

/// The constant tables of a net.
#[derive(Clone, Debug)]
pub(super) struct Layout {
    pub(super) transitions: usize,
    /// By block and transition: the flips of a firing in its own block.
    pub(super) own: Box<[[Bits; BLOCK]]>,
    /// By block: the transitions that have effects.
    pub(super) has_effects: Box<[u64]>,
    /// By transition.
    pub(super) effects: Ranges<Effect>,
    pub(super) far: Box<[Flip]>,
    /// By place: its flips if it is local.
    pub(super) flips: Ranges<Flip>,
    pub(super) places: Box<[Where]>,
    pub(super) shared: Box<[Shared]>,
    pub(super) joints: Box<[Joint]>,
    /// The blocks and the counts of the joints when every place is empty.
    pub(super) empty_blocks: Box<[Block]>,
    pub(super) empty_counts: Box<[u32]>,
}
