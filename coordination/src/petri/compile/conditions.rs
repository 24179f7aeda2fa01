//! What each transition needs, and which places are shared.

use crate::petri::id::PlaceId;
use crate::petri::layout::{BLOCK, Demand, LOCAL, PlaceEntry, SLOTS};
use crate::petri::model::{Arcs, Structure};

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

/// All places, of which none has positions yet.
pub(in crate::petri) struct Places {
    pub(in crate::petri) places: Vec<PlaceEntry>,
    pub(in crate::petri) shared: usize,
    /// For how many positions there has to be room.
    pub(in crate::petri) positions: usize,
}

impl Places {
    pub(in crate::petri) fn new(structure: &Structure) -> Self {
        let (mut shared, mut positions) = (0, 0);
        let all = structure.uses.iter().zip(&structure.marked);
        let places = all.map(|(user, &marked)| {
            let is_in_several_blocks = user.spans_groups_of(BLOCK);
            let mut place = PlaceEntry::local(positions, is_in_several_blocks, marked);
            if is_in_several_blocks && user.arcs > LOCAL {
                place.share(shared);
                shared += 1;
            } else {
                positions += user.arcs;
            }
            place
        });
        let places = places.collect();
        let mut all = Self {
            places,
            shared: shared as usize,
            positions: positions as usize,
        };
        let mut lists = structure.starts.windows(3).step_by(2);
        if lists.any(|ends| ends[2] - ends[0] > SLOTS as u32) {
            all.share_for_words(structure);
        }
        all
    }

    /// Of conditions that find no word, the places are shared: those that are used most.
    fn share_for_words(&mut self, structure: &Structure) {
        let mut local = Vec::new();
        for arcs in structure.arcs().filter(|arcs| arcs.places.len() > SLOTS) {
            local.clear();
            for_conditions(arcs, |place, _| {
                if !self.places[place.index()].is_shared() {
                    local.push(place.index());
                }
            });
            if local.len() > SLOTS {
                local.sort_by_key(|&place| structure.uses[place].arcs);
                for &place in &local[SLOTS..] {
                    self.places[place].share(self.shared as u32);
                    self.shared += 1;
                }
            }
        }
    }
}
