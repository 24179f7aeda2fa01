//! The arcs of a model, transition by transition.

use alloc::boxed::Box;
use alloc::vec;

use crate::petri::id::PlaceId;

/// An arc in numbers.
#[derive(Clone, Copy, Debug)]
pub(in crate::petri) struct NumberedArc {
    /// At twice the index of a transition are its inputs, behind that are its outputs.
    pub(in crate::petri) list: u32,
    pub(in crate::petri) place: u32,
}

const NO_LIST: u32 = u32::MAX;

/// How a place is used.
#[derive(Clone, Copy, Debug)]
pub(in crate::petri) struct Use {
    /// The first list that it is in, and the last; [`NO_LIST`] if it is in none.
    first: u32,
    last: u32,
    /// How many arcs it has, and how many of them enter it.
    pub(in crate::petri) arcs: u32,
    pub(in crate::petri) into: u32,
}

impl Use {
    const NONE: Self = Self {
        first: NO_LIST,
        last: NO_LIST,
        arcs: 0,
        into: 0,
    };

    /// The first transition that mentions the place, and the last.
    #[inline]
    pub(in crate::petri) fn transitions(&self) -> [usize; 2] {
        [self.first, self.last].map(|list| list as usize / 2)
    }

    /// Whether the first and the last transition that mention the place are in different groups of
    /// `transitions` each.
    pub(in crate::petri) fn spans_groups_of(&self, transitions: usize) -> bool {
        let [first, last] = self.transitions();
        first / transitions != last / transitions
    }
}

#[derive(Debug)]
pub(in crate::petri) struct Lists {
    /// Where each list begins, and where the last ends.
    pub(in crate::petri) starts: Box<[u32]>,
    pub(in crate::petri) places: Box<[PlaceId]>,
    /// By place.
    pub(in crate::petri) uses: Box<[Use]>,
    /// By transition, whether some place is in both of its lists.
    pub(in crate::petri) self_loops: Box<[bool]>,
    /// Whether some place is in a list twice.
    pub(in crate::petri) has_duplicates: bool,
}

impl Lists {
    /// Of arcs that come list by list, as they do from most models; nothing of others, or if one is
    /// no arc.
    #[inline]
    pub(in crate::petri) fn of_ordered(
        arcs: impl ExactSizeIterator<Item = Option<NumberedArc>>,
        place_count: usize,
        transition_count: usize,
    ) -> Option<Self> {
        let mut starts = vec![0; 2 * transition_count + 1];
        let mut places = vec![PlaceId(0); arcs.len()];
        let mut uses = vec![Use::NONE; place_count];
        let mut self_loops = vec![false; transition_count];
        let mut has_duplicates = false;
        let mut begun = 0;
        for ((arc, entry), index) in arcs.zip(&mut places).zip(0..) {
            let NumberedArc { list, place } = arc?;
            if list as usize + 1 < begun {
                return None;
            }
            while begun <= list as usize {
                starts[begun] = index;
                begun += 1;
            }
            *entry = PlaceId(place as u16);
            let user = &mut uses[place as usize];
            let before = core::mem::replace(&mut user.last, list);
            if before == NO_LIST {
                user.first = list;
            }
            has_duplicates |= before == list;
            let is_output = list % 2;
            user.arcs += 1;
            user.into += is_output;
            if is_output == 1 && before == list - 1 {
                self_loops[list as usize / 2] = true;
            }
        }
        starts[begun..].fill(places.len() as u32);
        Some(Self {
            starts: starts.into(),
            places: places.into(),
            uses: uses.into(),
            self_loops: self_loops.into(),
            has_duplicates,
        })
    }
}
