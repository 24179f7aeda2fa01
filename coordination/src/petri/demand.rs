//! What transitions ask of places, and do to them.

use alloc::vec::Vec;

use super::id::PlaceId;
use super::model::Arcs;

/// What a condition asks of its place, and what the transition does to it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::petri) enum Demand {
    /// It is marked, and is emptied.
    Marked,
    /// It is marked, and stays so.
    MarkedAndKept,
    /// It is empty, and is marked.
    Empty,
}

impl Demand {
    #[inline]
    pub(in crate::petri) fn is_met(self, marked: bool) -> bool {
        marked == (self != Self::Empty)
    }

    /// Whether the place changes.
    #[inline]
    pub(in crate::petri) fn changes(self) -> bool {
        self != Self::MarkedAndKept
    }
}

/// Calls `each` with what a transition demands: of its inputs, then of its outputs that are no inputs.
#[inline(always)]
pub(in crate::petri) fn for_conditions(arcs: Arcs, mut each: impl FnMut(PlaceId, Demand)) {
    let loops = if arcs.has_self_loop {
        self_loops(arcs)
    } else {
        Vec::new()
    };
    for (index, &place) in arcs.places.iter().enumerate() {
        let is_input = index < arcs.inputs;
        let is_kept = arcs.has_self_loop && loops.binary_search(&place).is_ok();
        if is_input || !is_kept {
            let demand = match (is_input, is_kept) {
                (false, _) => Demand::Empty,
                (true, false) => Demand::Marked,
                (true, true) => Demand::MarkedAndKept,
            };
            each(place, demand);
        }
    }
}

/// The places that are input and output, in order.
#[inline(never)]
fn self_loops(arcs: Arcs) -> Vec<PlaceId> {
    let (inputs, outputs) = arcs.places.split_at(arcs.inputs);
    // Either list may be long.
    let mut inputs = inputs.to_vec();
    inputs.sort_unstable();
    let is_input = |place: &PlaceId| inputs.binary_search(place).is_ok();
    let mut loops: Vec<_> = outputs.iter().copied().filter(is_input).collect();
    loops.sort_unstable();
    loops
}
