//! What each transition needs, and how each place is used.

use super::layout::{BLOCK, LOCAL, Place, SLOTS};
use super::net::TransitionId;
use super::structure::Structure;

/// A place in the conditions of one transition.
#[derive(Clone, Copy)]
pub(super) struct Condition(u32);

impl Condition {
    const WHEN_MARKED: u32 = 1 << 31;
    const CHANGES: u32 = 1 << 30;

    pub(super) fn place(self) -> usize {
        (self.0 & !(Self::WHEN_MARKED | Self::CHANGES)) as usize
    }

    /// Holds while the place is marked, else while it is empty.
    pub(super) fn when_marked(self) -> bool {
        self.0 & Self::WHEN_MARKED != 0
    }

    /// Firing changes the place, after which the condition does not hold.
    pub(super) fn changes(self) -> bool {
        self.0 & Self::CHANGES != 0
    }
}

/// The conditions of all transitions: of each its inputs, then its outputs that are not inputs.
pub(super) struct Conditions {
    starts: Vec<u32>,
    all: Vec<Condition>,
    /// Some transition has more than it can have as local ones.
    too_many: bool,
}

impl Conditions {
    pub(super) fn new(structure: &Structure) -> Self {
        let mut conditions = Self {
            starts: Vec::with_capacity(structure.transition_count() + 1),
            all: Vec::with_capacity(structure.arc_count()),
            too_many: false,
        };
        conditions.starts.push(0);
        for transition in structure.transitions() {
            let before = conditions.all.len();
            if structure.has_self_loop(transition) {
                conditions.add_with_self_loops(structure, transition);
            } else {
                let inputs = structure.inputs(transition).iter();
                let outputs = structure.outputs(transition).iter();
                let needs = Condition::WHEN_MARKED | Condition::CHANGES;
                let inputs = inputs.map(|place| Condition(u32::from(place.0) | needs));
                conditions.all.extend(inputs);
                let needs = Condition::CHANGES;
                let outputs = outputs.map(|place| Condition(u32::from(place.0) | needs));
                conditions.all.extend(outputs);
            }
            let count = conditions.all.len();
            conditions.too_many |= count - before > SLOTS;
            conditions.starts.push(count as u32);
        }
        conditions
    }

    fn add_with_self_loops(&mut self, structure: &Structure, transition: TransitionId) {
        let (inputs, outputs) = (structure.inputs(transition), structure.outputs(transition));
        // Either list may be long.
        let (mut known_inputs, mut known_outputs) = (inputs.to_vec(), outputs.to_vec());
        known_inputs.sort_unstable();
        known_outputs.sort_unstable();
        for place in inputs {
            let changes = match known_outputs.binary_search(place) {
                Ok(_) => 0,
                Err(_) => Condition::CHANGES,
            };
            let number = u32::from(place.0);
            self.all
                .push(Condition(number | Condition::WHEN_MARKED | changes));
        }
        for place in outputs {
            if known_inputs.binary_search(place).is_err() {
                let number = u32::from(place.0);
                self.all.push(Condition(number | Condition::CHANGES));
            }
        }
    }

    pub(super) fn of(&self, transition: usize) -> &[Condition] {
        &self.all[self.starts[transition] as usize..self.starts[transition + 1] as usize]
    }

    pub(super) fn transitions(&self) -> usize {
        self.starts.len() - 1
    }
}

/// How a place is used.
#[derive(Clone, Copy, Default)]
struct Use {
    conditions: u32,
    /// Blocks that mention it, and the last of them.
    blocks: u16,
    last_block: u16,
}

/// All places, none of which has flips yet; how many flips there will be, and how many shared places
/// there are.
pub(super) fn places(conditions: &Conditions, count: usize) -> (Vec<Place>, usize, usize) {
    let several_blocks = conditions.transitions() > BLOCK;
    if !several_blocks && !conditions.too_many {
        let places = (0..count as u32).map(Place::local);
        return (places.collect(), count, 0);
    }
    let mut uses = vec![Use::default(); count];
    for transition in 0..conditions.transitions() {
        let block = (transition / BLOCK) as u16;
        for condition in conditions.of(transition) {
            let user = &mut uses[condition.place()];
            user.blocks += u16::from(user.conditions == 0 || user.last_block != block);
            user.last_block = block;
            user.conditions += 1;
        }
    }
    let mut shared = 0;
    let mut flips = 0;
    let mut places = Vec::with_capacity(count);
    places.extend(uses.iter().map(|user| {
        if user.blocks > 1 && user.conditions > LOCAL {
            shared += 1;
            Place::shared(shared - 1)
        } else {
            flips += u32::from(user.blocks);
            Place::local(flips - u32::from(user.blocks))
        }
    }));
    if conditions.too_many {
        share_more(conditions, &uses, &mut places, &mut shared);
    }
    (places, flips as usize, shared as usize)
}

/// Of conditions that find no word, shares the places: those that are used most.
fn share_more(conditions: &Conditions, uses: &[Use], places: &mut [Place], shared: &mut u32) {
    let mut local = Vec::new();
    for transition in 0..conditions.transitions() {
        let all = conditions.of(transition);
        if all.len() <= SLOTS {
            continue;
        }
        local.clear();
        let all = all.iter().map(|condition| condition.place());
        local.extend(all.filter(|&place| !places[place].is_shared()));
        if local.len() > SLOTS {
            local.sort_by_key(|&place| uses[place].conditions);
            for &place in &local[SLOTS..] {
                places[place] = Place::shared(*shared);
                *shared += 1;
            }
        }
    }
}
