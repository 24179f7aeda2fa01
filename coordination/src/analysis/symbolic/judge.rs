//! What is wrong with states as such, and with what they do next.

use super::super::refusal::Reason;
use super::diagram::{Grown, Set};
use super::rules::{Literal, TrapKind};
use super::space::Space;

/// What is wrong with one of the states.
pub(super) enum Finding {
    /// This state, by its true variables, is faulty.
    Fault(Vec<u32>, Box<Reason>),
    /// An event has to wait for a source, for which there are no variables yet.
    Waits,
}

impl Space<'_> {
    /// A fault of one of these states. Faults of the same kind as the explicit search names first
    /// are named first here.
    pub(super) fn finding(&self, set: &Set) -> Grown<Option<Finding>> {
        if let Some(state) = self.excluded(set)? {
            return Ok(self.fault_as_such(state));
        }
        for protocol in 0..self.closed.protocols().len() {
            if let Some(state) = self.out_of_order(set, protocol)? {
                return Ok(self.fault_as_such(state));
            }
        }
        if let Some(found) = self.trapped(set)? {
            return Ok(Some(found));
        }
        Ok(self.stuck(set)?.any().map(|stuck| {
            let state = self.state(&stuck);
            let reason = self.closed.deadlock(&state);
            Finding::Fault(stuck, Box::new(reason))
        }))
    }

    fn fault_as_such(&self, state: Vec<u32>) -> Option<Finding> {
        let reason = self.closed.fault(&self.state(&state))?;
        Some(Finding::Fault(state, reason))
    }

    /// A state with two marked places of an exclusion.
    fn excluded(&self, set: &Set) -> Grown<Option<Vec<u32>>> {
        for places in self.closed.exclusions() {
            let (mut none, mut one) = (set.clone(), self.empty());
            for place in places {
                let variable = self.rules.numbers.places[place as usize];
                let two = one.with(variable)?;
                if let Some(state) = two.any() {
                    return Ok(Some(state));
                }
                one = one.union(&none.with(variable)?)?;
                none = none.without(variable)?;
            }
        }
        Ok(None)
    }

    /// A state with a marked sink whose flag is not next. Looks at every combination of marked sinks
    /// and a position that occurs.
    fn out_of_order(&self, set: &Set, protocol: usize) -> Grown<Option<Vec<u32>>> {
        let numbers = &self.rules.numbers;
        let sinks: Vec<u32> = self.closed.sinks_of_protocol(protocol).collect();
        // With the sinks looked at so far either marked or not, and how many of them are.
        let mut split = vec![(set.clone(), 0)];
        for sink in sinks {
            let variable = numbers.places[sink as usize];
            let mut finer = Vec::with_capacity(split.len() + 1);
            for (part, marked) in split {
                let (with, without) = (part.with(variable)?, part.without(variable)?);
                finer.extend([(with, marked + 1), (without, marked)]);
            }
            finer.retain(|(part, _)| !part.is_empty());
            split = finer;
        }
        for (part, _) in split.into_iter().filter(|&(_, marked)| marked > 0) {
            for &variable in &numbers.positions[protocol] {
                let Some(state) = part.with(variable)?.any() else {
                    continue;
                };
                if self.closed.is_out_of_order(&self.state(&state), protocol) {
                    return Ok(Some(state));
                }
            }
        }
        Ok(None)
    }

    fn trapped(&self, set: &Set) -> Grown<Option<Finding>> {
        for trap in &self.rules.traps {
            let Some(state) = self.that(set, &trap.tests)?.any() else {
                continue;
            };
            let reason = match trap.kind {
                TrapKind::Unsafe { transition, place } => {
                    self.closed.second_token(transition, place)
                }
                TrapKind::Overflow { .. } if self.rules.waiting < self.closed.max_waiting() => {
                    return Ok(Some(Finding::Waits));
                }
                TrapKind::Overflow { source } => self.closed.overflow(source, self.rules.waiting),
            };
            return Ok(Some(Finding::Fault(state, Box::new(reason))));
        }
        Ok(None)
    }

    /// The states in which nothing can happen and which are no ends.
    fn stuck(&self, set: &Set) -> Grown<Set> {
        let mut stuck = set.clone();
        for rule in &self.rules.rules {
            if stuck.is_empty() {
                return Ok(stuck);
            }
            stuck = stuck.minus(&self.applies(&stuck, rule)?)?;
            self.breathe()?;
        }
        for end in self.ends()? {
            stuck = stuck.minus(&end)?;
        }
        Ok(stuck)
    }

    /// The states that are ends, by end.
    pub(super) fn ends(&self) -> Grown<Vec<Set>> {
        let numbers = &self.rules.numbers;
        let start = |list: &Vec<u32>| list.first().copied();
        let mut ends = Vec::new();
        for places in self.closed.end_places() {
            let marked = places.map(|place| numbers.places[place as usize]);
            let starts = numbers.positions.iter().filter_map(start);
            let mut end = self.diagram.only(marked.chain(starts))?;
            // An event without a protocol may have come.
            for source in self.closed.event_sources() {
                end = end.union(&end.toggled(numbers.places[source as usize])?)?;
            }
            ends.push(end);
        }
        Ok(ends)
    }

    /// The states that lack least of what these tests ask.
    pub(super) fn nearest_to(&self, set: &Set, tests: &[Literal]) -> Grown<Set> {
        // By how much was lacking so far.
        let mut lacking = vec![set.clone()];
        for test in tests.iter().filter(|test| test.before.is_some()) {
            let mut next = vec![self.empty(); lacking.len() + 1];
            for (count, states) in lacking.iter().enumerate() {
                let (with, without) = (states.with(test.variable)?, states.without(test.variable)?);
                let (has, lacks) = match test.before {
                    Some(true) => (with, without),
                    _ => (without, with),
                };
                next[count] = next[count].union(&has)?;
                next[count + 1] = next[count + 1].union(&lacks)?;
            }
            lacking = next;
            self.breathe()?;
        }
        let least = lacking.into_iter().find(|states| !states.is_empty());
        Ok(least.unwrap_or_else(|| self.empty()))
    }

    /// A state by its true variables, as the explicit search has it.
    pub(super) fn state(&self, variables: &[u32]) -> Vec<u64> {
        let meanings = variables
            .iter()
            .map(|&variable| self.rules.meanings[variable as usize]);
        self.closed.state_of(meanings)
    }
}
