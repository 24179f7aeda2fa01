//! An executor as Fig. 4 of the paper describes it, for comparison: maps in flat arrays, bit arrays,
//! circular to-do buffers of places without repeats, one transition at a time.
//!
//! It is meant to be as fast as that design can be: places and transitions are small integers, a
//! place is inspected only when it became marked, and the first transition that can fire does so at
//! once, so that `transitions_to_fire` never holds more than one and is left out. The history counts
//! firings per transition, which is what "every enabled transition has already fired" asks for, and
//! carries the number of the evaluation, so that nothing is cleared between two. As in the paper, a
//! transition is enabled when its inputs are marked; outputs are not looked at, which is right for
//! these families and saves it work. Of several transitions of a place it takes the first behind the
//! one that it took last, so that it fires as much as ours does.

use coordination::petri::{PlaceId, PlaceKind, Structure, TransitionId};

/// Lists of numbers in one array: a pointer and a number of entries for each index.
struct Map {
    pointer: Box<[u32]>,
    number: Box<[u16]>,
    entries: Box<[u16]>,
}

impl Map {
    fn new<'a>(lists: impl ExactSizeIterator<Item = &'a [PlaceId]>, entries: usize) -> Self {
        let mut pointer = Vec::with_capacity(lists.len());
        let mut number = Vec::with_capacity(lists.len());
        let mut all = Vec::with_capacity(entries);
        for list in lists {
            pointer.push(all.len() as u32);
            number.push(list.len() as u16);
            all.extend(list.iter().map(|place| place.0));
        }
        Self {
            pointer: pointer.into(),
            number: number.into(),
            entries: all.into(),
        }
    }

    #[inline]
    fn of(&self, index: usize) -> &[u16] {
        let from = self.pointer[index] as usize;
        &self.entries[from..from + usize::from(self.number[index])]
    }
}

/// A bit per index.
struct Bits(Box<[u8]>);

impl Bits {
    fn new(count: usize) -> Self {
        Self(vec![0; count.div_ceil(8)].into())
    }

    #[inline]
    fn get(&self, index: u16) -> bool {
        self.0[usize::from(index / 8)] >> (index % 8) & 1 == 1
    }

    #[inline]
    fn set(&mut self, index: u16) {
        self.0[usize::from(index / 8)] |= 1 << (index % 8);
    }

    #[inline]
    fn clear(&mut self, index: u16) {
        self.0[usize::from(index / 8)] &= !(1 << (index % 8));
    }
}

/// A circular buffer of places, each in it at most once.
struct ToDo {
    /// As many as a power of two, at least one per place.
    places: Box<[u16]>,
    first: usize,
    len: usize,
    is_place_already_in_buffer: Bits,
}

impl ToDo {
    fn new(places: usize) -> Self {
        Self {
            places: vec![0; places.next_power_of_two()].into(),
            first: 0,
            len: 0,
            is_place_already_in_buffer: Bits::new(places),
        }
    }

    #[inline]
    fn push(&mut self, place: u16) {
        if !self.is_place_already_in_buffer.get(place) {
            self.is_place_already_in_buffer.set(place);
            let mask = self.places.len() - 1;
            self.places[(self.first + self.len) & mask] = place;
            self.len += 1;
        }
    }

    #[inline]
    fn pop(&mut self) -> Option<u16> {
        if self.len == 0 {
            return None;
        }
        let place = self.places[self.first];
        self.first = (self.first + 1) & (self.places.len() - 1);
        self.len -= 1;
        self.is_place_already_in_buffer.clear(place);
        Some(place)
    }
}

pub struct Figure4 {
    place_to_transitions: Map,
    /// By place: where among its transitions to look first.
    next_transition: Box<[u16]>,
    transition_input_place: Map,
    transition_output_place: Map,
    sink_places: Bits,
    marking: Bits,
    places_to_process: ToDo,
    places_to_skip: ToDo,
    /// By transition: the last evaluation in which it fired.
    history: Box<[u32]>,
    evaluation: u32,
}

impl Figure4 {
    pub fn new(net: &Structure) -> Self {
        let transitions = net.transition_count();
        let places = net.place_count();
        let mut number = vec![0_u16; places];
        for transition in net.transitions() {
            for place in net.inputs(transition) {
                number[place.index()] += 1;
            }
        }
        let mut pointer = vec![0_u32; places];
        let mut sum = 0;
        for (pointer, &number) in pointer.iter_mut().zip(&number) {
            *pointer = sum;
            sum += u32::from(number);
        }
        let mut next = pointer.clone();
        let mut entries = vec![0_u16; sum as usize];
        for transition in net.transitions() {
            for place in net.inputs(transition) {
                let next = &mut next[place.index()];
                entries[*next as usize] = transition.0;
                *next += 1;
            }
        }
        let inputs = entries.len();
        let outputs = net.arc_count() - inputs;
        let mut executor = Self {
            place_to_transitions: Map {
                pointer: pointer.into(),
                number: number.into(),
                entries: entries.into(),
            },
            next_transition: vec![0; places].into(),
            transition_input_place: Map::new(net.transitions().map(|t| net.inputs(t)), inputs),
            transition_output_place: Map::new(net.transitions().map(|t| net.outputs(t)), outputs),
            sink_places: Bits::new(places),
            marking: Bits::new(places),
            places_to_process: ToDo::new(places),
            places_to_skip: ToDo::new(places),
            history: vec![0; transitions].into(),
            evaluation: 0,
        };
        for place in net.places() {
            if net.kind(place) == PlaceKind::Sink {
                executor.sink_places.set(place.0);
            }
            if net.marked(place) {
                executor.mark(place.0);
            }
        }
        executor
    }

    #[inline]
    fn mark(&mut self, place: u16) {
        self.marking.set(place);
        if !self.sink_places.get(place) {
            self.places_to_process.push(place);
        }
    }

    pub fn set_marking(&mut self, places: &[PlaceId]) {
        while self.places_to_process.pop().is_some() {}
        while self.places_to_skip.pop().is_some() {}
        self.marking.0.fill(0);
        for place in places {
            self.mark(place.0);
        }
    }

    pub fn is_marked(&self, place: PlaceId) -> bool {
        self.marking.get(place.0)
    }

    /// Fires each transition at most once, until none is enabled that has not fired, or until
    /// `firings` have. Returns how many fired.
    pub fn evaluate(&mut self, firings: u32, mut on_fire: impl FnMut(TransitionId)) -> u32 {
        self.evaluation += 1;
        while let Some(place) = self.places_to_skip.pop() {
            self.places_to_process.push(place);
        }
        let mut fired = 0;
        while fired < firings {
            let Some(place) = self.places_to_process.pop() else {
                break;
            };
            if !self.marking.get(place) {
                continue;
            }
            let (chosen, fired_already) = self.choose(usize::from(place));
            if let Some(transition) = chosen {
                self.fire(transition);
                on_fire(TransitionId(transition));
                fired += 1;
            } else if fired_already {
                self.places_to_skip.push(place);
            }
        }
        fired
    }

    /// The transition of a marked place to fire, or else whether one is enabled that has fired.
    #[inline]
    fn choose(&mut self, place: usize) -> (Option<u16>, bool) {
        let transitions = self.place_to_transitions.of(place);
        let first = usize::from(self.next_transition[place]);
        let mut fired_already = false;
        for index in (first..transitions.len()).chain(0..first) {
            let transition = transitions[index];
            if self.is_enabled(transition) {
                if self.history[usize::from(transition)] != self.evaluation {
                    let behind = index + 1;
                    self.next_transition[place] = if behind < transitions.len() {
                        behind as u16
                    } else {
                        0
                    };
                    return (Some(transition), false);
                }
                fired_already = true;
            }
        }
        (None, fired_already)
    }

    #[inline]
    fn is_enabled(&self, transition: u16) -> bool {
        let inputs = self.transition_input_place.of(usize::from(transition));
        inputs.iter().all(|&place| self.marking.get(place))
    }

    #[inline]
    fn fire(&mut self, transition: u16) {
        self.history[usize::from(transition)] = self.evaluation;
        for &place in self.transition_input_place.of(usize::from(transition)) {
            self.marking.clear(place);
        }
        for &place in self.transition_output_place.of(usize::from(transition)) {
            self.marking.set(place);
            if !self.sink_places.get(place) {
                self.places_to_process.push(place);
            }
        }
    }
}
