//! Lays a net out; see [the layout](super::layout).

use std::collections::HashMap;

use super::changes::{Changes, Dependents, SharedMark, add_bit, span};
use super::conditions::{for_conditions, places};
use super::layout::{
    BLOCK, Bits, Block, CHUNK, Effects, Flip, Layout, OPEN, OpenFlip, Place, PortChange, SLOTS,
    Span, Special,
};
use super::net::{PlaceId, TransitionId};
use super::state::State;
use super::structure::Structure;
use crate::event::EventId;

/// The tables of `structure`, and its state with all places empty. `sources` and `sinks` are in the
/// order of their places.
pub(super) fn compile(
    structure: &Structure,
    sources: &[(PlaceId, EventId)],
    sinks: &[(PlaceId, EventId)],
) -> (Layout, State) {
    let mut tables = Tables::new(structure);
    for transition in structure.transitions() {
        tables.add_conditions(structure, transition);
    }
    tables.add_readable_bits(structure);
    tables.finish(structure, sources, sinks)
}

/// The tables that are filled transition by transition.
struct Tables {
    places: Vec<Place>,
    flips: Vec<Flip>,
    shared: Vec<Dependents>,
    /// By joint: its members.
    joints: Vec<Vec<OpenFlip>>,
    joint_of: HashMap<Vec<SharedMark>, u32>,
    // With all places empty:
    blocks: Vec<Block>,
    open: Vec<u64>,
    unmet: Vec<u32>,
}

impl Tables {
    fn new(structure: &Structure) -> Self {
        let transitions = structure.transition_count();
        let (places, shared) = places(structure);
        let last = places.last().expect("a transition has inputs");
        let no_flip = Flip {
            block: u32::MAX,
            bits: [0; SLOTS],
        };
        let block_count = transitions.div_ceil(BLOCK);
        let mut blocks = vec![empty_block(!0); block_count];
        blocks[block_count - 1] = empty_block(!0 >> (block_count * BLOCK - transitions));
        Self {
            flips: vec![no_flip; (last.first_flip + last.flips) as usize],
            places,
            shared: vec![Dependents::default(); shared],
            joints: Vec::new(),
            joint_of: HashMap::new(),
            blocks,
            open: vec![!0; block_count.next_multiple_of(CHUNK)],
            unmet: Vec::new(),
        }
    }

    /// Gives each condition of a transition its place in the tables.
    fn add_conditions(&mut self, structure: &Structure, transition: TransitionId) {
        let block = transition.index() / BLOCK;
        let bit = 1 << (transition.index() % BLOCK);
        let mut slot = 0;
        let mut shared_count = 0;
        let mut last_shared = None;
        for_conditions(structure, transition, |condition| {
            let place = &mut self.places[condition.place];
            if place.is_shared() {
                last_shared = Some(condition);
                shared_count += 1;
                return;
            }
            if condition.when_marked {
                self.blocks[block].conditions[slot] &= !bit;
            }
            // Transitions come in order: the flips used last are this block's, or the next are.
            let flips = &mut self.flips[place.first_flip as usize..][..place.flips as usize];
            let flip = flips
                .iter_mut()
                .find(|flip| flip.block == block as u32 || flip.block == u32::MAX)
                .expect("a place has flips for every block that mentions it");
            flip.block = block as u32;
            flip.bits[slot] |= bit;
            place.transition = transition.index() as u32;
            place.slot = slot as u8;
            place.when_marked = condition.when_marked;
            slot += 1;
        });
        let Some(condition) = last_shared else {
            return;
        };
        let (flips, closed) = if shared_count == 1 {
            let place = &mut self.places[condition.place];
            place.transition = transition.index() as u32;
            place.slot = OPEN;
            place.when_marked = condition.when_marked;
            let shared = &mut self.shared[place.shared as usize];
            (&mut shared.open, condition.when_marked)
        } else {
            let joint = self.joint(structure, transition);
            (&mut self.joints[joint], self.unmet[joint] > 0)
        };
        add_bit(flips, block, bit);
        if closed {
            self.open[block] &= !bit;
        }
    }

    /// The joint of a transition with several shared conditions.
    fn joint(&mut self, structure: &Structure, transition: TransitionId) -> usize {
        let mut key = Vec::new();
        for_conditions(structure, transition, |condition| {
            let place = &self.places[condition.place];
            if place.is_shared() {
                key.push((place.shared, condition.when_marked));
            }
        });
        key.sort_unstable();
        if let Some(&joint) = self.joint_of.get(&key) {
            return joint as usize;
        }
        let joint = self.joints.len();
        let mut unmet = 0;
        for &(shared, when_marked) in &key {
            let joints = &mut self.shared[shared as usize].joints;
            joints.push((joint as u32, when_marked));
            unmet += u32::from(when_marked);
        }
        self.joints.push(Vec::new());
        self.unmet.push(unmet);
        self.joint_of.insert(key, joint as u32);
        joint
    }

    /// Gives every shared place that only joints mention a bit behind the transitions.
    fn add_readable_bits(&mut self, structure: &Structure) {
        let mut next = structure.transition_count();
        for place in self.places.iter_mut().filter(|place| place.is_shared()) {
            let flips = &mut self.shared[place.shared as usize].open;
            if !flips.is_empty() {
                continue;
            }
            let (block, bit) = (next / BLOCK, 1 << (next % BLOCK));
            if block == self.open.len() {
                self.open.extend([!0; CHUNK]);
            }
            self.open[block] &= !bit;
            add_bit(flips, block, bit);
            // No transition becomes ready by it.
            flips[0].blocks = 0;
            place.transition = next as u32;
            place.slot = OPEN;
            place.when_marked = true;
            next += 1;
        }
    }

    fn finish(
        mut self,
        structure: &Structure,
        sources: &[(PlaceId, EventId)],
        sinks: &[(PlaceId, EventId)],
    ) -> (Layout, State) {
        let mut changes = Changes::default();
        let shared = self.shared.iter();
        let shared: Vec<_> = shared.map(|place| changes.of_place(place)).collect();
        let joints = self.joints.iter().map(|members| changes.add(members));
        let joints: Vec<_> = joints.collect();
        let transitions = structure.transition_count();
        let mut layout = Layout {
            transitions,
            own: vec![[[0; SLOTS]; BLOCK]; self.blocks.len()].into(),
            specials: Box::default(),
            effects: Box::default(),
            changes: Box::default(),
            far: Box::default(),
            port_changes: Box::default(),
            open_flips: Box::default(),
            joint_changes: Box::default(),
            joints: joints.into(),
            places: self.places.into(),
            flips: self.flips.into(),
            shared: shared.into(),
        };
        let ports = (sources, sinks);
        add_firings(
            &mut layout,
            &mut self.blocks,
            structure,
            ports,
            &mut changes,
        );
        layout.changes = changes.several.into();
        layout.open_flips = changes.open.into();
        layout.joint_changes = changes.joints.into();
        (
            layout,
            State::new(self.blocks.into(), self.open.into(), self.unmet.into()),
        )
    }
}

fn empty_block(existing: u64) -> Block {
    Block {
        conditions: [existing, !0, !0, !0],
        fresh: !0,
        special: 0,
    }
}

/// Combines what the places do that each firing changes.
fn add_firings(
    layout: &mut Layout,
    blocks: &mut [Block],
    structure: &Structure,
    (sources, sinks): (&[(PlaceId, EventId)], &[(PlaceId, EventId)]),
    changes: &mut Changes,
) {
    let index_of = |ports: &[(PlaceId, EventId)], place| {
        let found = ports.binary_search_by_key(&place, |&(place, _)| place.index());
        found.ok().map(|index| index as u16)
    };
    let mut specials = Vec::new();
    let mut effects = Vec::new();
    let mut far: Vec<Flip> = Vec::new();
    let mut ports = Vec::new();
    let mut shared: Vec<SharedMark> = Vec::new();
    for transition in structure.transitions() {
        let (block, lane) = (transition.index() / BLOCK, transition.index() % BLOCK);
        let before = (far.len(), ports.len());
        shared.clear();
        let mut own = [0; SLOTS];
        for_conditions(structure, transition, |condition| {
            if !condition.changes {
                return;
            }
            let place = &layout.places[condition.place];
            if place.is_shared() {
                shared.push((place.shared, !condition.when_marked));
            }
            for flip in layout.flips_of(place) {
                if flip.block as usize == block {
                    flip_bits(&mut own, &flip.bits);
                    continue;
                }
                let mut known = far[before.0..].iter_mut();
                match known.find(|known| known.block == flip.block) {
                    Some(known) => flip_bits(&mut known.bits, &flip.bits),
                    None => far.push(*flip),
                }
            }
            ports.extend(if condition.when_marked {
                index_of(sources, condition.place).map(PortChange::SourceEmptied)
            } else {
                index_of(sinks, condition.place).map(PortChange::SinkFilled)
            });
        });
        layout.own[block][lane] = own;
        let (mut change, further) = changes.of_places(&shared, &layout.shared);
        let mut special = Special::NOTHING;
        if let Some(first) = take_first(&mut change.open) {
            special.open = changes.open[first];
        }
        if let Some(first) = take_first(&mut change.joints) {
            special.joint = changes.joints[first];
        }
        let (open, joints) = (change.open, change.joints);
        let more = !(open.is_empty() && joints.is_empty() && further.is_empty());
        if more || before != (far.len(), ports.len()) {
            special.more = effects.len() as u32;
            effects.push(Effects {
                far: span(before.0, far.len()),
                ports: span(before.1, ports.len()),
                change,
                changes: further,
            });
        }
        if !shared.is_empty() || special.more != Special::NONE {
            blocks[block].special |= 1 << lane;
            specials.resize(transition.index(), Special::NOTHING);
            specials.push(special);
        }
    }
    layout.specials = specials.into();
    layout.effects = effects.into();
    layout.far = far.into();
    layout.port_changes = ports.into();
}

fn flip_bits(bits: &mut Bits, flips: &Bits) {
    for (bits, flips) in bits.iter_mut().zip(flips) {
        *bits ^= flips;
    }
}

/// The first index of a span, which is cut off.
fn take_first(span: &mut Span) -> Option<usize> {
    let first = span.start;
    (first < span.end).then(|| {
        span.start += 1;
        first as usize
    })
}
