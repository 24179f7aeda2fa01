//! The constant tables of a net; see [masks](super).

use alloc::boxed::Box;

use crate::petri::id::PlaceId;
use crate::petri::ports::PortChange;
use crate::petri::span::Span;

/// The most blocks of a net. A search in vain may look at all transitions of all blocks, so it is
/// limited by this: a thousand looks, about a microsecond.
pub(in crate::petri) const MAX_BLOCKS: usize = 16;

/// Places in a word, and transitions in a block.
pub(in crate::petri) const BITS: usize = u64::BITS as usize;

/// What a transition asks of a word, and does to it.
#[derive(Clone, Copy, Debug, Default)]
pub(in crate::petri) struct Row {
    /// The places that matter.
    pub(in crate::petri) mask: u64,
    /// Their marks while it is enabled.
    pub(in crate::petri) value: u64,
    /// The places that change.
    pub(in crate::petri) flip: u64,
    /// The transitions of its block that may be enabled then.
    pub(in crate::petri) wakes: u64,
}

impl Row {
    pub(in crate::petri) const NEVER: Self = Self {
        mask: 0,
        value: 1,
        flip: 0,
        wakes: 0,
    };

    #[inline(always)]
    pub(in crate::petri) fn is_met(&self, marks: u64) -> bool {
        marks & self.mask == self.value
    }
}

/// By bit of a word: the transitions of a block that need the place empty, and those that need it marked.
pub(in crate::petri) type Users = [[u64; 2]; BITS];

/// Where a place is.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(in crate::petri) struct Spot {
    /// The block, or [`Spot::SHARED`].
    pub(in crate::petri) block: u8,
    /// The bit of the word.
    pub(in crate::petri) bit: u8,
}

impl Spot {
    pub(in crate::petri) const SHARED: u8 = u8::MAX;

    pub(in crate::petri) fn is_shared(self) -> bool {
        self.block == Self::SHARED
    }

    pub(in crate::petri) fn mask(self) -> u64 {
        1 << (usize::from(self.bit) % BITS)
    }
}

#[derive(Clone, Debug)]
pub(in crate::petri) struct Layout {
    /// By transition, and at last one that is never met.
    pub(in crate::petri) rows: Box<[Row]>,
    /// By place; empty if the net is one word, whose bits are the places in order.
    pub(in crate::petri) spots: Box<[Spot]>,
    /// Those of all blocks, one behind the other; of a net that is one word only of its places.
    pub(in crate::petri) users: Box<[[u64; 2]]>,
    /// The bits of the shared places, in the word of every block.
    pub(in crate::petri) shared: u64,
    /// By bit of a shared place, from the highest: the blocks that may have something to do when it is emptied, and
    /// when it is marked.
    pub(in crate::petri) neighbours: Box<[[u64; 2]]>,
    pub(in crate::petri) has_ports: bool,
    /// By transition: its [`PortChange`]s; empty if the net has no ports.
    pub(in crate::petri) ports_of: Box<[Span]>,
    pub(in crate::petri) port_changes: Box<[PortChange]>,
}

impl Layout {
    /// What a firing does to sources and sinks.
    #[inline]
    pub(in crate::petri) fn port_changes(&self, transition: usize) -> &[PortChange] {
        let span = self.ports_of.get(transition).copied().unwrap_or_default();
        span.of(&self.port_changes)
    }

    /// The blocks that may have something to do when the shared place of this bit is marked, or emptied.
    #[inline]
    pub(in crate::petri) fn neighbours(&self, bit: usize, is_marked: bool) -> u64 {
        self.neighbours[BITS - 1 - bit][usize::from(is_marked)]
    }

    #[inline]
    pub(in crate::petri) fn spot(&self, place: PlaceId) -> Spot {
        let one_word = Spot {
            block: 0,
            bit: place.index() as u8,
        };
        self.spots.get(place.index()).copied().unwrap_or(one_word)
    }
}
