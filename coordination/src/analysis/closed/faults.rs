//! What is wrong with a state of a closed net, and whether it is an end.

use super::super::refusal::Reason;
use super::describe::next_flags;
use super::net::Closed;
use crate::protocol::{FlagId, Position};

impl Closed<'_> {
    /// What is wrong with a state as such.
    pub(in crate::analysis) fn fault(&self, state: &[u64]) -> Option<Box<Reason>> {
        let marking = self.layout.marking(state);
        for exclusion in &self.exclusions {
            let both = |(a, b): (&u64, &u64)| (a & b).count_ones();
            if marking.iter().zip(&exclusion.words).map(both).sum::<u32>() > 1 {
                return Some(Box::new(Reason::Exclusion {
                    exclusion: exclusion.name.clone(),
                    places: self.names_of(marking.iter().zip(&exclusion.words).map(|(a, b)| a & b)),
                }));
            }
        }
        (0..self.uses.len()).find_map(|protocol| self.out_of_order(state, protocol))
    }

    /// From where the protocol is, marked sinks alone must lead to the flag of every marked sink.
    pub(super) fn out_of_order(&self, state: &[u64], number: usize) -> Option<Box<Reason>> {
        let (used, bound) = (&self.uses[number], &self.bound[number]);
        let is_marked = |&&(sink, _): &&(u32, FlagId)| self.layout.is_marked(state, sink);
        let mut pending: Vec<(u32, FlagId)> =
            bound.sinks.iter().filter(is_marked).copied().collect();
        if pending.is_empty() {
            return None;
        }
        let mut reached = vec![self.position(state, number)];
        let mut at = Position::START;
        while let Some(position) = reached.pop() {
            at = position;
            pending.retain(|&(_, flag)| match used.protocol.after(position, flag) {
                Some(to) => {
                    reached.push(used.after(to));
                    false
                }
                None => true,
            });
        }
        let &(sink, flag) = pending.first()?;
        Some(Box::new(Reason::OutOfOrder {
            sink: self.places[sink as usize].clone(),
            protocol: used.name.clone(),
            flag: used.protocol.flag_name(flag).to_owned(),
            done: match at {
                Position::START => String::new(),
                at => used.protocol.describe(at).to_string(),
            },
            next: next_flags(used, at),
        }))
    }

    /// Which end a state is, if it is one.
    pub(in crate::analysis) fn end(&self, state: &[u64]) -> Option<usize> {
        if self.ends.is_empty()
            || !self.layout.nothing_waits(state)
            || (0..self.uses.len()).any(|number| !self.is_between_runs(state, number))
        {
            return None;
        }
        let marking = self.layout.marking(state);
        self.ends.iter().position(|end| {
            let places = marking.iter().zip(&self.at_end).map(|(a, b)| a & b);
            places.eq(end.words.iter().copied())
        })
    }
}
