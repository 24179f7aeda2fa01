//! Which places are shared.

use alloc::vec::Vec;

use crate::petri::blocks::layout::{BLOCK, LOCAL, PlaceEntry, SLOTS};
use crate::petri::demand::for_conditions;
use crate::petri::model::Structure;

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
