//! What each transition needs, and how each place is used.

use super::layout::{BLOCK, LOCAL, Place, SLOTS};
use super::net::TransitionId;
use super::structure::Structure;

/// A place in the conditions of one transition.
#[derive(Clone, Copy)]
pub(super) struct Condition {
    pub(super) place: usize,
    /// Holds while the place is marked, else while it is empty.
    pub(super) when_marked: bool,
    /// Firing changes the place, after which the condition does not hold.
    pub(super) changes: bool,
}

/// Calls `each` with every condition of a transition: inputs, then outputs that are not inputs.
#[inline]
pub(super) fn for_conditions(
    structure: &Structure,
    transition: TransitionId,
    mut each: impl FnMut(Condition),
) {
    let inputs = structure.inputs(transition);
    let outputs = structure.outputs(transition);
    if !structure.has_self_loop(transition) {
        for (places, when_marked) in [(inputs, true), (outputs, false)] {
            for place in places {
                each(Condition {
                    place: place.index(),
                    when_marked,
                    changes: true,
                });
            }
        }
        return;
    }
    // Either list may be long.
    let (mut known_inputs, mut known_outputs) = (inputs.to_vec(), outputs.to_vec());
    known_inputs.sort_unstable();
    known_outputs.sort_unstable();
    for place in inputs {
        each(Condition {
            place: place.index(),
            when_marked: true,
            changes: known_outputs.binary_search(place).is_err(),
        });
    }
    for place in outputs {
        if known_inputs.binary_search(place).is_err() {
            each(Condition {
                place: place.index(),
                when_marked: false,
                changes: true,
            });
        }
    }
}

/// All places, with room for their flips, and how many are shared.
pub(super) fn places(structure: &Structure) -> (Vec<Place>, usize) {
    let unused = Place {
        shared: Place::NOT_SHARED,
        first_flip: 0,
        flips: 0,
        transition: u32::MAX,
        slot: 0,
        when_marked: false,
    };
    let mut places = vec![unused; structure.place_count()];
    // For now, `first_flip` counts conditions, `flips` blocks, and `transition` is the last user.
    let mut many = false;
    for transition in structure.transitions() {
        let (inputs, outputs) = (structure.inputs(transition), structure.outputs(transition));
        many |= inputs.len() + outputs.len() > SLOTS;
        let number = transition.index() as u32;
        for id in inputs.iter().chain(outputs) {
            let place = &mut places[id.index()];
            let new_block = place.transition / BLOCK as u32 != number / BLOCK as u32;
            place.flips += u32::from(place.flips == 0 || new_block);
            place.transition = number;
            place.first_flip += 1;
        }
    }
    let mut shared = 0;
    let mut share = |place: &mut Place| {
        place.shared = shared;
        shared += 1;
    };
    for place in &mut places {
        if place.flips > 1 && place.first_flip > LOCAL {
            share(place);
        }
    }
    if many {
        // Conditions that find no word: those on the places used most.
        let mut local = Vec::new();
        for transition in structure.transitions() {
            local.clear();
            for_conditions(structure, transition, |condition| {
                if !places[condition.place].is_shared() {
                    local.push(condition.place);
                }
            });
            if local.len() > SLOTS {
                local.sort_by_key(|&place| places[place].first_flip);
                for &place in &local[SLOTS..] {
                    share(&mut places[place]);
                }
            }
        }
    }
    let mut first_flip = 0;
    for place in &mut places {
        if place.is_shared() {
            place.flips = 0;
        }
        place.first_flip = first_flip;
        first_flip += place.flips;
    }
    (places, shared as usize)
}
