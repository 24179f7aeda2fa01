//! The semantics of a net, as simply as it can be written: sets of numbers, and a look at every
//! transition before every step. It shares no code with the library but the symbolic model.

use std::collections::{BTreeMap, BTreeSet};

use coordination::petri::{NetModel, PlaceKind};

#[derive(Clone)]
struct Transition {
    inputs: BTreeSet<usize>,
    outputs: BTreeSet<usize>,
}

/// A net that runs, place by place and transition by transition.
#[derive(Clone)]
pub struct Reference {
    transitions: Vec<Transition>,
    /// Source to event name.
    sources: BTreeMap<usize, String>,
    /// Sink to event name.
    sinks: BTreeMap<usize, String>,
    pub marking: BTreeSet<usize>,
    pub waiting: BTreeMap<usize, u32>,
    /// Full sinks in the order in which they filled.
    pub full: Vec<usize>,
    last: usize,
}

/// What one evaluation did.
#[derive(Debug, PartialEq, Eq)]
pub struct Outcome {
    pub fired: Vec<usize>,
    pub remaining: bool,
}

impl Reference {
    pub fn new(model: &NetModel) -> Self {
        let mut numbers = BTreeMap::new();
        let mut sources = BTreeMap::new();
        let mut sinks = BTreeMap::new();
        let mut marking = BTreeSet::new();
        for (number, place) in model.places().enumerate() {
            numbers.insert(place.name.to_owned(), number);
            if place.marked {
                marking.insert(number);
            }
            let event = place.binding.map(|binding| binding.event_name());
            match place.kind {
                PlaceKind::Internal => {}
                PlaceKind::Source => {
                    sources.insert(number, event.unwrap());
                }
                PlaceKind::Sink => {
                    sinks.insert(number, event.unwrap());
                }
            }
        }
        let set = |names: &[&str]| names.iter().map(|&name| numbers[name]).collect();
        let transitions: Vec<_> = model
            .transitions()
            .map(|transition| Transition {
                inputs: set(&transition.inputs),
                outputs: set(&transition.outputs),
            })
            .collect();
        Self {
            last: transitions.len() - 1,
            waiting: sources.keys().map(|&source| (source, 0)).collect(),
            full: { sinks.keys() }
                .copied()
                .filter(|sink| marking.contains(sink))
                .collect(),
            transitions,
            sources,
            sinks,
            marking,
        }
    }

    /// `false` if no source knows the event.
    pub fn offer(&mut self, event: &str) -> bool {
        let mut known = false;
        for (source, name) in &self.sources {
            if name == event {
                *self.waiting.get_mut(source).unwrap() += 1;
                known = true;
            }
        }
        known
    }

    fn fill_sources(&mut self) {
        for (source, waiting) in &mut self.waiting {
            if *waiting > 0 && self.marking.insert(*source) {
                *waiting -= 1;
            }
        }
    }

    /// The transitions that are enabled once sources are filled.
    pub fn enabled_next(&self) -> Vec<usize> {
        let mut next = self.clone();
        next.fill_sources();
        let all = 0..next.transitions.len();
        all.filter(|&transition| next.enabled(transition)).collect()
    }

    /// Fires one out of turn; `false` if it is not enabled.
    pub fn fire_by_hand(&mut self, transition: usize) -> bool {
        let is_enabled = self.enabled_next().contains(&transition);
        if is_enabled {
            let last = self.last;
            self.fill_sources();
            self.fire(transition);
            self.last = last;
        }
        is_enabled
    }

    pub fn evaluate(&mut self, firings: usize, rounds: u32) -> Outcome {
        self.fill_sources();
        let mut fired = Vec::new();
        let mut round = 1;
        let mut in_round = BTreeSet::new();
        while fired.len() < firings && round <= rounds {
            if let Some(transition) = self.choose(|t| !in_round.contains(&t)) {
                self.fire(transition);
                in_round.insert(transition);
                fired.push(transition);
            } else if self.choose(|_| true).is_some() {
                round += 1;
                in_round.clear();
            } else {
                break;
            }
        }
        let can_fill = self
            .waiting
            .iter()
            .any(|(source, &waiting)| waiting > 0 && !self.marking.contains(source));
        Outcome {
            fired,
            remaining: can_fill || self.choose(|_| true).is_some(),
        }
    }

    fn choose(&self, allowed: impl Fn(usize) -> bool) -> Option<usize> {
        let behind = self.last + 1..self.transitions.len();
        behind
            .chain(0..=self.last)
            .find(|&t| allowed(t) && self.enabled(t))
    }

    fn enabled(&self, transition: usize) -> bool {
        let Transition { inputs, outputs } = &self.transitions[transition];
        inputs.is_subset(&self.marking)
            && outputs
                .difference(inputs)
                .all(|output| !self.marking.contains(output))
    }

    fn fire(&mut self, transition: usize) {
        let Transition { inputs, outputs } = &self.transitions[transition];
        for input in inputs {
            self.marking.remove(input);
        }
        for output in outputs {
            self.marking.insert(*output);
            if self.sinks.contains_key(output) {
                self.full.push(*output);
            }
        }
        self.last = transition;
    }

    /// Shows each full sink with its event to `accept`; empties it if that agrees.
    pub fn drain(&mut self, mut accept: impl FnMut(usize, &str) -> bool) {
        let full = std::mem::take(&mut self.full);
        for sink in full {
            if accept(sink, &self.sinks[&sink]) {
                self.marking.remove(&sink);
            } else {
                self.full.push(sink);
            }
        }
    }

    pub fn set_marking(&mut self, marking: BTreeSet<usize>) {
        self.full = { self.sinks.keys() }
            .copied()
            .filter(|sink| marking.contains(sink))
            .collect();
        self.marking = marking;
    }
}
