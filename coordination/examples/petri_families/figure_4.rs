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

use std::marker::PhantomData;
use std::ops::{Deref, DerefMut};

use bytemuck::{Pod, Zeroable};
use coordination::petri::{PlaceId, PlaceKind, Structure, TransitionId};

/// Begins on a cache line and is padded to whole ones, as each array of Fig. 4.
struct Array<T> {
    lines: Box<[Line]>,
    entries: PhantomData<T>,
}

#[derive(Clone, Copy, Pod, Zeroable)]
#[repr(C, align(64))]
struct Line([u8; 64]);

impl<T: Pod> Array<T> {
    /// At least `count` zeros.
    fn zeros(count: usize) -> Self {
        let lines = (count * size_of::<T>()).div_ceil(size_of::<Line>());
        Self {
            lines: vec![Line::zeroed(); lines].into(),
            entries: PhantomData,
        }
    }
}

impl<T: Pod> Deref for Array<T> {
    type Target = [T];

    #[inline]
    fn deref(&self) -> &[T] {
        bytemuck::cast_slice(&self.lines)
    }
}

impl<T: Pod> DerefMut for Array<T> {
    #[inline]
    fn deref_mut(&mut self) -> &mut [T] {
        bytemuck::cast_slice_mut(&mut self.lines)
    }
}

/// Lists of numbers in one array: a pointer and a number of entries for each index.
struct Map {
    pointer: Array<u32>,
    number: Array<u16>,
    entries: Array<u16>,
}

impl Map {
    fn new<'a>(lists: impl ExactSizeIterator<Item = &'a [PlaceId]>, entries: usize) -> Self {
        let mut map = Self {
            pointer: Array::zeros(lists.len()),
            number: Array::zeros(lists.len()),
            entries: Array::zeros(entries),
        };
        let all = &mut map.entries[..];
        let mut next = 0;
        let index = map.pointer.iter_mut().zip(&mut *map.number);
        for (list, (pointer, number)) in lists.zip(index) {
            *pointer = next as u32;
            *number = list.len() as u16;
            for (entry, place) in all[next..].iter_mut().zip(list) {
                *entry = place.0;
            }
            next += list.len();
        }
        map
    }

    #[inline]
    fn of(&self, index: usize) -> &[u16] {
        let from = self.pointer[index] as usize;
        &self.entries[from..from + usize::from(self.number[index])]
    }
}

/// A bit per index.
struct Bits(Array<u8>);

impl Bits {
    fn new(count: usize) -> Self {
        Self(Array::zeros(count.div_ceil(8)))
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
    /// At least one per place.
    places: Array<u16>,
    /// As many of them are used, a power of two, less one.
    mask: usize,
    first: usize,
    len: usize,
    is_place_already_in_buffer: Bits,
}

impl ToDo {
    fn new(places: usize) -> Self {
        Self {
            places: Array::zeros(places.next_power_of_two()),
            mask: places.next_power_of_two() - 1,
            first: 0,
            len: 0,
            is_place_already_in_buffer: Bits::new(places),
        }
    }

    #[inline]
    fn push(&mut self, place: u16) {
        if !self.is_place_already_in_buffer.get(place) {
            self.is_place_already_in_buffer.set(place);
            let last = (self.first + self.len) & self.mask;
            self.places[last] = place;
            self.len += 1;
        }
    }

    #[inline]
    fn pop(&mut self) -> Option<u16> {
        if self.len == 0 {
            return None;
        }
        let place = self.places[self.first];
        self.first = (self.first + 1) & self.mask;
        self.len -= 1;
        self.is_place_already_in_buffer.clear(place);
        Some(place)
    }
}

pub struct Figure4 {
    place_to_transitions: Map,
    /// By place: where among its transitions to look first.
    next_transition: Array<u16>,
    transition_input_place: Map,
    transition_output_place: Map,
    sink_places: Bits,
    marking: Bits,
    places_to_process: ToDo,
    places_to_skip: ToDo,
    /// By transition: the last evaluation in which it fired.
    history: Array<u32>,
    evaluation: u32,
}

impl Figure4 {
    pub fn new(net: &Structure) -> Self {
        let transitions = net.transition_count();
        let places = net.place_count();
        let mut number: Array<u16> = Array::zeros(places);
        let mut inputs = 0;
        for transition in net.transitions() {
            for place in net.inputs(transition) {
                number[place.index()] += 1;
                inputs += 1;
            }
        }
        let mut pointer: Array<u32> = Array::zeros(places);
        let mut next = vec![0; places];
        let mut sum = 0;
        let index = pointer.iter_mut().zip(&*number);
        for (next, (pointer, &number)) in next.iter_mut().zip(index) {
            *pointer = sum;
            *next = sum as usize;
            sum += u32::from(number);
        }
        let mut entries: Array<u16> = Array::zeros(inputs);
        for transition in net.transitions() {
            for place in net.inputs(transition) {
                let next = &mut next[place.index()];
                entries[*next] = transition.0;
                *next += 1;
            }
        }
        let outputs = net.arc_count() - inputs;
        let mut executor = Self {
            place_to_transitions: Map {
                pointer,
                number,
                entries,
            },
            next_transition: Array::zeros(places),
            transition_input_place: Map::new(net.transitions().map(|t| net.inputs(t)), inputs),
            transition_output_place: Map::new(net.transitions().map(|t| net.outputs(t)), outputs),
            sink_places: Bits::new(places),
            marking: Bits::new(places),
            places_to_process: ToDo::new(places),
            places_to_skip: ToDo::new(places),
            history: Array::zeros(transitions),
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
