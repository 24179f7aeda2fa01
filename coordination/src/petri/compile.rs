//! Lays a net out; see [the layout](super::layout).

use std::collections::HashMap;

use super::layout::{
    BLOCK, Bits, Block, Effect, Flip, Joint, LOCAL_BLOCKS, Layout, Ranges, Row, SLOTS, Shared,
    Where,
};
use super::net::{PlaceId, TransitionId};
use super::structure::Structure;
use crate::event::EventId;

const NOT_SHARED: u32 = u32::MAX;

/// A place in the conditions of one transition.
#[derive(Clone, Copy)]
struct Condition {
    place: PlaceId,
    /// Holds while the place is marked, else while it is empty.
    when_marked: bool,
    /// Firing changes the place, after which the condition does not hold.
    changes: bool,
}

/// How a place is used.
#[derive(Clone, Copy)]
struct Use {
    conditions: u32,
    /// How many blocks mention it, and the last one that did.
    blocks: u32,
    last_block: u32,
    /// Index among the shared places.
    shared: u32,
}

/// The tables of `structure`. `sources` and `sinks` are in the order of their places.
pub(super) fn compile(
    structure: &Structure,
    sources: &[(PlaceId, EventId)],
    sinks: &[(PlaceId, EventId)],
) -> Layout {
    let conditions = conditions(structure);
    let (uses, shared_count) = uses(structure, &conditions);
    let mut tables = Tables::new(structure, &uses, shared_count);
    for transition in structure.transitions() {
        tables.place_conditions(transition, conditions.of(transition.index()), &uses);
    }
    tables.layout(structure, &conditions, &uses, sources, sinks)
}

/// The conditions of every transition: inputs, then outputs that are not inputs.
fn conditions(structure: &Structure) -> Ranges<Condition> {
    const NEVER: u32 = u32::MAX;
    let mut input_of = vec![NEVER; structure.place_count()];
    let mut output_of = vec![NEVER; structure.place_count()];
    let mut starts = Vec::with_capacity(structure.transition_count() + 1);
    let mut items = Vec::with_capacity(structure.arc_count());
    starts.push(0);
    for transition in structure.transitions() {
        let number = transition.index() as u32;
        for place in structure.outputs(transition) {
            output_of[place.index()] = number;
        }
        for &place in structure.inputs(transition) {
            input_of[place.index()] = number;
            items.push(Condition {
                place,
                when_marked: true,
                changes: output_of[place.index()] != number,
            });
        }
        for &place in structure.outputs(transition) {
            if input_of[place.index()] != number {
                items.push(Condition {
                    place,
                    when_marked: false,
                    changes: true,
                });
            }
        }
        starts.push(items.len() as u32);
    }
    Ranges {
        starts: starts.into(),
        items: items.into(),
    }
}

/// Decides which places are shared; how every place is used, and how many are shared.
fn uses(structure: &Structure, conditions: &Ranges<Condition>) -> (Vec<Use>, usize) {
    let unused = Use {
        conditions: 0,
        blocks: 0,
        last_block: u32::MAX,
        shared: NOT_SHARED,
    };
    let mut uses = vec![unused; structure.place_count()];
    for transition in structure.transitions() {
        let block = (transition.index() / BLOCK) as u32;
        for condition in conditions.of(transition.index()) {
            let user = &mut uses[condition.place.index()];
            user.conditions += 1;
            if user.last_block != block {
                user.last_block = block;
                user.blocks += 1;
            }
        }
    }
    let mut shared = 0;
    let mut share = |user: &mut Use| {
        user.shared = shared;
        shared += 1;
    };
    for user in &mut uses {
        if user.blocks > LOCAL_BLOCKS {
            share(user);
        }
    }
    // Conditions that find no slot: the places used most.
    let mut local = Vec::new();
    for transition in structure.transitions() {
        let all = conditions.of(transition.index());
        if all.len() <= SLOTS {
            continue;
        }
        local.clear();
        let places = all.iter().map(|condition| condition.place.index());
        local.extend(places.filter(|&place| uses[place].shared == NOT_SHARED));
        if local.len() > SLOTS {
            local.sort_by_key(|&place| uses[place].conditions);
            for &place in &local[SLOTS..] {
                share(&mut uses[place]);
            }
        }
    }
    (uses, shared as usize)
}

/// The tables that are filled transition by transition.
struct Tables {
    blocks: Box<[Block]>,
    places: Box<[Where]>,
    flips: Ranges<Flip>,
    shared: Box<[Shared]>,
    joints: Vec<Joint>,
    counts: Vec<u32>,
    joint_of: HashMap<Vec<(u32, bool)>, u32>,
}

impl Tables {
    fn new(structure: &Structure, uses: &[Use], shared: usize) -> Self {
        let block_count = structure.transition_count().div_ceil(BLOCK);
        let empty = Block {
            conditions: [!0; SLOTS],
            open: !0,
            fresh: !0,
        };
        let mut blocks = vec![empty; block_count].into_boxed_slice();
        let in_last = structure.transition_count() - (block_count - 1) * BLOCK;
        blocks[block_count - 1].conditions[0] = !0 >> (BLOCK - in_last);

        let mut starts = Vec::with_capacity(uses.len() + 1);
        let mut places = Vec::with_capacity(uses.len());
        let mut sum = 0;
        starts.push(sum);
        for user in uses {
            let local = user.shared == NOT_SHARED;
            sum += if local { user.blocks } else { 0 };
            starts.push(sum);
            places.push(Where::Shared(user.shared));
        }
        let none = Flip {
            block: u32::MAX,
            bits: [0; SLOTS],
        };
        Self {
            blocks,
            places: places.into(),
            flips: Ranges {
                starts: starts.into(),
                items: vec![none; sum as usize].into(),
            },
            shared: vec![Shared::default(); shared].into(),
            joints: Vec::new(),
            counts: Vec::new(),
            joint_of: HashMap::new(),
        }
    }

    /// Gives each condition of a transition its place in the tables, as of an empty net.
    fn place_conditions(&mut self, transition: TransitionId, all: &[Condition], uses: &[Use]) {
        let block = transition.index() / BLOCK;
        let bit = 1 << (transition.index() % BLOCK);
        let mut slot = 0;
        let mut shared = None;
        let mut shared_count = 0;
        for condition in all {
            let place = condition.place.index();
            if uses[place].shared != NOT_SHARED {
                shared = Some((uses[place].shared, condition.when_marked));
                shared_count += 1;
                continue;
            }
            if condition.when_marked {
                self.blocks[block].conditions[slot] &= !bit;
            }
            let from = self.flips.starts[place] as usize;
            let to = self.flips.starts[place + 1] as usize;
            let flips = &mut self.flips.items[from..to];
            if flips[0].block == u32::MAX {
                self.places[place] = Where::Local {
                    transition: transition.index() as u32,
                    slot: slot as u8,
                    when_marked: condition.when_marked,
                };
            }
            // Transitions come in order: the block's flips are the last used ones or the next.
            let flip = flips
                .iter_mut()
                .find(|flip| flip.block == block as u32 || flip.block == u32::MAX)
                .expect("a place has flips for every block that mentions it");
            flip.block = block as u32;
            flip.bits[slot] |= bit;
            slot += 1;
        }
        match shared {
            Some((index, when_marked)) if shared_count == 1 => {
                add(&mut self.shared[index as usize].row, block, bit);
                if when_marked {
                    self.blocks[block].open &= !bit;
                }
            }
            Some(_) => {
                let joint = self.joint(all, uses);
                add(&mut self.joints[joint].row, block, bit);
                if self.counts[joint] > 0 {
                    self.blocks[block].open &= !bit;
                }
            }
            None => {}
        }
    }

    /// The joint of a transition with several shared conditions.
    fn joint(&mut self, all: &[Condition], uses: &[Use]) -> usize {
        let mut key: Vec<_> = all
            .iter()
            .map(|condition| (uses[condition.place.index()].shared, condition.when_marked))
            .filter(|&(shared, _)| shared != NOT_SHARED)
            .collect();
        key.sort_unstable();
        if let Some(&joint) = self.joint_of.get(&key) {
            return joint as usize;
        }
        let joint = self.joints.len() as u32;
        let mut count = 0;
        for &(shared, when_marked) in &key {
            self.shared[shared as usize]
                .joints
                .push((joint, when_marked));
            count += u32::from(when_marked);
        }
        self.joints.push(Joint::default());
        self.counts.push(count);
        self.joint_of.insert(key, joint);
        joint as usize
    }

    /// Combines the flips of the places that each firing changes.
    fn layout(
        self,
        structure: &Structure,
        conditions: &Ranges<Condition>,
        uses: &[Use],
        sources: &[(PlaceId, EventId)],
        sinks: &[(PlaceId, EventId)],
    ) -> Layout {
        let transitions = structure.transition_count();
        let mut own = vec![[[0; SLOTS]; BLOCK]; self.blocks.len()].into_boxed_slice();
        let mut has_effects = vec![0; self.blocks.len()].into_boxed_slice();
        let mut starts = Vec::with_capacity(transitions + 1);
        let mut effects = Vec::new();
        let mut far: Vec<Flip> = Vec::new();
        starts.push(0);
        for transition in structure.transitions() {
            let (block, lane) = (transition.index() / BLOCK, transition.index() % BLOCK);
            let first_effect = effects.len();
            let first_far = far.len();
            let all = conditions.of(transition.index());
            for condition in all.iter().filter(|condition| condition.changes) {
                let place = condition.place;
                let user = &uses[place.index()];
                if user.shared != NOT_SHARED {
                    effects.push(Effect::Shared(user.shared, !condition.when_marked));
                }
                for flip in self.flips.of(place.index()) {
                    if flip.block as usize == block {
                        flip_bits(&mut own[block][lane], &flip.bits);
                        continue;
                    }
                    let known = far[first_far..].iter_mut().find(|f| f.block == flip.block);
                    match known {
                        Some(known) => flip_bits(&mut known.bits, &flip.bits),
                        None => {
                            effects.push(Effect::Far(far.len() as u32));
                            far.push(*flip);
                        }
                    }
                }
                if condition.when_marked {
                    if let Ok(source) = sources.binary_search_by_key(&place, |&(place, _)| place) {
                        effects.push(Effect::SourceEmptied(source as u16));
                    }
                } else if let Ok(sink) = sinks.binary_search_by_key(&place, |&(place, _)| place) {
                    effects.push(Effect::SinkFilled(sink as u16));
                }
            }
            if effects.len() > first_effect {
                has_effects[block] |= 1 << lane;
            }
            starts.push(effects.len() as u32);
        }
        Layout {
            transitions,
            own,
            has_effects,
            effects: Ranges {
                starts: starts.into(),
                items: effects.into(),
            },
            far: far.into(),
            flips: self.flips,
            places: self.places,
            shared: self.shared,
            joints: self.joints.into(),
            empty_blocks: self.blocks,
            empty_counts: self.counts.into(),
        }
    }
}

fn flip_bits(bits: &mut Bits, flips: &Bits) {
    for (bits, flips) in bits.iter_mut().zip(flips) {
        *bits ^= flips;
    }
}

/// Adds a transition's bit to a row; transitions come in order.
fn add(row: &mut Row, block: usize, bit: u64) {
    match row.flips.last_mut() {
        Some((last, bits)) if *last == block as u32 => *bits |= bit,
        _ => row.flips.push((block as u32, bit)),
    }
    let (word, bit) = ((block / BLOCK) as u32, 1 << (block % BLOCK));
    match row.blocks.last_mut() {
        Some((last, bits)) if *last == word => *bits |= bit,
        _ => row.blocks.push((word, bit)),
    }
}
