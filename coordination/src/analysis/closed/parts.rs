//! Parts of a closed net that an exploration by sets asks for.

use std::collections::HashSet;

use super::net::{Closed, Move, Set};
use super::rule::Meaning;

impl Closed<'_> {
    pub(in crate::analysis) fn max_waiting(&self) -> u8 {
        self.max_waiting
    }

    /// The places of each exclusion.
    pub(in crate::analysis) fn exclusions(
        &self,
    ) -> impl Iterator<Item = impl Iterator<Item = u32>> {
        self.exclusions.iter().map(Set::places)
    }

    /// The marked places of each end.
    pub(in crate::analysis) fn end_places(
        &self,
    ) -> impl Iterator<Item = impl Iterator<Item = u32>> {
        self.ends.iter().map(Set::places)
    }

    pub(in crate::analysis) fn event_sources(&self) -> impl Iterator<Item = u32> {
        self.event_sources.iter().copied()
    }

    pub(in crate::analysis) fn sinks_of_protocol(
        &self,
        number: usize,
    ) -> impl Iterator<Item = u32> {
        self.bound[number].sinks.iter().map(|&(sink, _)| sink)
    }

    /// Whether a marked sink's flag is not next.
    pub(in crate::analysis) fn is_out_of_order(&self, state: &[u64], number: usize) -> bool {
        self.out_of_order(state, number).is_some()
    }

    /// The places that a transition asks something of: its inputs, and sinks that it marks.
    pub(in crate::analysis) fn asked(&self, transition: usize) -> HashSet<u32> {
        let arcs = &self.transitions[transition].1;
        arcs.inputs.iter().chain(&arcs.sinks).copied().collect()
    }

    /// A state by what is true in it.
    pub(in crate::analysis) fn state_of(
        &self,
        meanings: impl Iterator<Item = Meaning>,
    ) -> Vec<u64> {
        let (mut state, layout) = (vec![0; self.layout.words], self.layout);
        for meaning in meanings {
            match meaning {
                Meaning::Marked(place) => layout.mark(&mut state, place),
                Meaning::At(protocol, position) => {
                    let protocol = protocol as usize;
                    let position = self.bound[protocol].positions[position as usize];
                    layout.set_position(&mut state, protocol, position);
                }
                Meaning::Waiting(counter, count) => {
                    let counter = counter as usize;
                    let count = count.max(layout.waiting(&state, counter));
                    layout.set_waiting(&mut state, counter, count);
                }
            }
        }
        state
    }

    /// The steps that the net could take again and again without news from outside, as far as one
    /// sees by its arcs: none of those that take a token which no other such step puts back.
    pub(in crate::analysis) fn recurring(&self) -> HashSet<Move> {
        let sinks = { self.event_sinks.iter().copied() }.chain(
            self.bound
                .iter()
                .flat_map(|bound| bound.sinks.iter().map(|s| s.0)),
        );
        let firings = { self.transitions.iter().zip(0..) }.map(|((_, arcs), number)| {
            let puts = arcs.internal.iter().chain(&arcs.sinks);
            (
                Move::Fire(number),
                arcs.taken.clone(),
                puts.copied().collect(),
            )
        });
        let empties = sinks.map(|sink| (Move::Empty(sink), vec![sink], Vec::new()));
        let mut steps: Vec<(Move, Vec<u32>, Vec<u32>)> = firings.chain(empties).collect();
        loop {
            let put: HashSet<u32> = steps.iter().flat_map(|step| &step.2).copied().collect();
            let before = steps.len();
            steps.retain(|(_, taken, _)| taken.iter().all(|place| put.contains(place)));
            if steps.len() == before {
                return steps.into_iter().map(|(step, ..)| step).collect();
            }
        }
    }
}

impl Set {
    fn places(&self) -> impl Iterator<Item = u32> {
        let bits = |word: u64| (0..64).filter(move |bit| word >> bit & 1 == 1);
        let words = self.words.iter().zip(0_u32..);
        words.flat_map(move |(&word, number)| bits(word).map(move |bit| number * 64 + bit))
    }
}
