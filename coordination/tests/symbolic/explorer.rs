//! A net read on its own terms, one marking after another, as simply as it can be written.

use std::collections::{BTreeSet, HashMap, VecDeque};

use super::families::Net;

/// All markings of a net, and the firings between them.
pub struct Explorer<'n> {
    /// Each with its distance from the first.
    pub markings: Vec<(BTreeSet<&'n str>, usize)>,
    /// From, transition, to.
    pub firings: Vec<(usize, &'n str, usize)>,
}

impl<'n> Explorer<'n> {
    /// None if a second token would come.
    pub fn new(net: &'n Net) -> Option<Self> {
        let first: BTreeSet<&str> = { net.places.iter() }
            .filter_map(|(place, marked)| marked.then_some(place.as_str()))
            .collect();
        let mut numbers = HashMap::from([(first.clone(), 0)]);
        let mut found = Self {
            markings: vec![(first, 0)],
            firings: Vec::new(),
        };
        let mut waiting = VecDeque::from([0]);
        while let Some(from) = waiting.pop_front() {
            let (marking, distance) = found.markings[from].clone();
            for (name, inputs, outputs) in &net.transitions {
                if !inputs.iter().all(|place| marking.contains(place.as_str())) {
                    continue;
                }
                let mut next = marking.clone();
                next.retain(|place| !inputs.iter().any(|input| input == place));
                if !outputs.iter().all(|place| next.insert(place)) {
                    return None;
                }
                let to = *numbers.entry(next.clone()).or_insert_with(|| {
                    waiting.push_back(found.markings.len());
                    found.markings.push((next, distance + 1));
                    found.markings.len() - 1
                });
                found.firings.push((from, name, to));
            }
        }
        Some(found)
    }

    /// How far the nearest marking is that `holds`.
    pub fn nearest(&self, holds: impl Fn(usize, &BTreeSet<&str>) -> bool) -> Option<usize> {
        let all = self.markings.iter().enumerate();
        let held = all.filter(|(number, (marking, _))| holds(*number, marking));
        held.map(|(_, (_, distance))| *distance).min()
    }

    /// How far the nearest marking is in which nothing is enabled.
    pub fn deadlock(&self) -> Option<usize> {
        self.nearest(|number, _| self.firings.iter().all(|(from, ..)| *from != number))
    }

    /// How far the nearest marking is from which a transition can never fire any more.
    pub fn dies(&self, transition: &str) -> Option<usize> {
        let mut can = vec![false; self.markings.len()];
        for (from, fired, _) in &self.firings {
            can[*from] |= *fired == transition;
        }
        loop {
            let before = can.clone();
            for (from, _, to) in &self.firings {
                can[*from] |= can[*to];
            }
            if can == before {
                return self.nearest(|number, _| !can[number]);
            }
        }
    }
}
