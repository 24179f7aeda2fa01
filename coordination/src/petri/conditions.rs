//! What each transition needs, and which places are shared.

use super::layout::{BLOCK, LOCAL, Place, SLOTS};
use super::net::PlaceId;
use super::structure::{Arcs, Structure};

/// A place in the conditions of one transition.
#[derive(Clone, Copy)]
pub(super) struct Condition {
    pub(super) place: PlaceId,
    /// Holds while the place is marked, else while it is empty.
    pub(super) when_marked: bool,
    /// Firing changes the place, after which the condition does not hold.
    pub(super) changes: bool,
}

/// Calls `each` with the conditions of a transition: its inputs, then its outputs that are no inputs.
#[inline(always)]
pub(super) fn for_conditions(arcs: Arcs, mut each: impl FnMut(Condition)) {
    let loops = if arcs.has_self_loop {
        self_loops(arcs)
    } else {
        Vec::new()
    };
    for (index, &place) in arcs.places.iter().enumerate() {
        let is_input = index < arcs.inputs;
        let is_kept = arcs.has_self_loop && loops.binary_search(&place).is_ok();
        if is_input || !is_kept {
            each(Condition {
                place,
                when_marked: is_input,
                changes: !is_kept,
            });
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

/// All places, none of which has flips yet, and how many of them are shared.
pub(super) fn places(structure: &Structure) -> (Vec<Place>, usize) {
    let mut places = vec![Place::LOCAL; structure.place_count()];
    let transitions = structure.transition_count();
    let too_many = structure.arcs().any(|arcs| arcs.places.len() > SLOTS);
    if !too_many && (transitions <= BLOCK || structure.most_arcs() <= LOCAL) {
        return (places, 0);
    }
    let mut uses = vec![Use::default(); places.len()];
    for (transition, arcs) in structure.arcs().enumerate() {
        let block = (transition / BLOCK) as u32;
        for place in arcs.places {
            let user = &mut uses[place.index()];
            user.blocks += u32::from(user.arcs == 0 || user.last_block != block);
            user.last_block = block;
            user.arcs += 1;
        }
    }
    let mut shared = 0;
    let mut share = |place: &mut Place| {
        *place = Place::shared(shared);
        shared += 1;
    };
    for (place, user) in places.iter_mut().zip(&uses) {
        if user.blocks > 1 && user.arcs > LOCAL {
            share(place);
        }
    }
    // Of conditions that find no word, the places are shared: those that are used most.
    let mut local = Vec::new();
    for arcs in structure.arcs().filter(|arcs| arcs.places.len() > SLOTS) {
        local.clear();
        for_conditions(arcs, |condition| {
            if !places[condition.place.index()].is_shared() {
                local.push(condition.place.index());
            }
        });
        if local.len() > SLOTS {
            local.sort_by_key(|&place| uses[place].arcs);
            for &place in &local[SLOTS..] {
                share(&mut places[place]);
            }
        }
    }
    (places, shared as usize)
}

/// How a place is used.
#[derive(Clone, Copy, Default)]
struct Use {
    arcs: u32,
    /// Blocks that mention it.
    blocks: u32,
    last_block: u32,
}
