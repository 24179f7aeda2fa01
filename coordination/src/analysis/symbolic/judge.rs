//! What is wrong with states as such, and with what they do next.

use super::super::closed::rule::{Literal, Trap, TrapKind};
use super::super::refusal::Reason;
use super::diagram::{Grown, Set};
use super::space::Space;
use super::sweep::{Sweep, Way};

/// The faulty ones of some states, by how the search names them: those of the first kind first.
pub(super) struct Faulty {
    pub(super) kinds: Vec<Set>,
    /// Whether an event has to wait for a source for which there are no variables yet.
    pub(super) waits: bool,
}

/// The states that would take a step after which it is not defined what happens.
pub(super) struct Trapped {
    /// To a second token in a place.
    pub(super) second: Set,
    /// To one event too many.
    pub(super) overflows: Set,
    /// Whether an event has to wait for a source for which there are no variables yet.
    pub(super) waits: bool,
}

impl Space<'_> {
    pub(super) fn trapped(&self, set: &Set) -> Grown<Trapped> {
        let as_such = |tests: &Trap| matches!(tests.kind, TrapKind::Unsafe { .. });
        let (second, more): (Vec<_>, Vec<_>) = self.rules.traps.iter().partition(|t| as_such(t));
        let trapped = |traps: Vec<&Trap>| {
            let tests = traps.iter().map(|trap| &*trap.tests);
            Sweep::of_tests(self, tests).once(set)
        };
        let overflows = trapped(more)?;
        Ok(Trapped {
            waits: self.rules.waiting < self.closed.max_waiting() && !overflows.is_empty(),
            second: trapped(second)?,
            overflows,
        })
    }

    pub(super) fn faulty(&self, set: &Set) -> Grown<Faulty> {
        let Trapped {
            second,
            overflows,
            waits,
        } = self.trapped(set)?;
        let kinds = vec![
            self.excluded(set)?,
            self.out_of_order(set)?,
            second,
            overflows,
            self.stuck(set)?,
        ];
        Ok(Faulty { kinds, waits })
    }

    /// What is wrong with a faulty state, by its true variables.
    pub(super) fn reason(&self, variables: &[u32]) -> Grown<Box<Reason>> {
        let state = self.state(variables);
        if let Some(reason) = self.closed.fault(&state) {
            return Ok(reason);
        }
        self.trap(variables)
    }

    /// What a state would do wrong next, by its true variables.
    pub(super) fn trap(&self, variables: &[u32]) -> Grown<Box<Reason>> {
        let only = self.diagram.only(variables.iter().copied())?;
        for trap in &self.rules.traps {
            if !self.that(&only, &trap.tests)?.is_empty() {
                return Ok(Box::new(match trap.kind {
                    TrapKind::Unsafe { transition, place } => {
                        self.closed.second_token(transition, place)
                    }
                    TrapKind::Overflow { source } => {
                        self.closed.overflow(source, self.rules.waiting)
                    }
                }));
            }
        }
        Ok(Box::new(self.closed.deadlock(&self.state(variables))))
    }

    /// The states with two marked places of an exclusion.
    fn excluded(&self, set: &Set) -> Grown<Set> {
        let mut found = self.empty();
        for places in self.closed.exclusions() {
            let (mut none, mut one) = (set.clone(), self.empty());
            for place in places {
                let variable = self.rules.numbers.places[place as usize];
                found = found.union(&one.with(variable)?)?;
                one = one.without(variable)?.union(&none.with(variable)?)?;
                none = none.without(variable)?;
            }
        }
        Ok(found)
    }

    /// The states with a marked sink whose flag is not next. Looks at every combination of a protocol's
    /// marked sinks and its position that occurs.
    fn out_of_order(&self, set: &Set) -> Grown<Set> {
        let (numbers, mut found) = (&self.rules.numbers, self.empty());
        for protocol in 0..self.closed.protocols().len() {
            // With the sinks looked at so far either marked or not, and how many of them are.
            let mut parts = vec![(set.clone(), 0)];
            for sink in self.closed.sinks_of_protocol(protocol) {
                let variable = numbers.places[sink as usize];
                let mut finer = Vec::with_capacity(parts.len() + 1);
                for (part, marked) in parts {
                    let (with, without) = (part.with(variable)?, part.without(variable)?);
                    finer.extend([(with, marked + 1), (without, marked)]);
                }
                finer.retain(|(part, _)| !part.is_empty());
                parts = finer;
            }
            for (part, _) in parts.into_iter().filter(|&(_, marked)| marked > 0) {
                for &variable in &numbers.positions[protocol] {
                    let part = part.with(variable)?;
                    let state = part.any().map(|state| self.state(&state));
                    if state.is_some_and(|state| self.closed.is_out_of_order(&state, protocol)) {
                        found = found.union(&part)?;
                    }
                }
            }
            self.breathe()?;
        }
        Ok(found)
    }

    /// The states in which nothing can happen.
    pub(super) fn blocked(&self, set: &Set) -> Grown<Set> {
        let rules = self.rules.rules.iter();
        let goes_on = Sweep::of_rules(self, Way::Stays, rules).once(set)?;
        set.minus(&goes_on)
    }

    /// The states in which nothing can happen and which are no ends.
    fn stuck(&self, set: &Set) -> Grown<Set> {
        let mut stuck = self.blocked(set)?;
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
