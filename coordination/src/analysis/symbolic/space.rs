//! Sets of states of a closed net, and where its rules lead from them.

use std::time::Instant;

use super::super::closed::Closed;
use super::super::closed::rule::{Literal, Rule, Rules};
use super::super::usage::Limits;
use super::diagram::{Diagram, Exhausted, Grown, Set};
use super::order::order;

/// A closed net with the diagram that its states are in.
pub(super) struct Space<'a> {
    pub(super) closed: &'a Closed<'a>,
    pub(super) rules: Rules,
    pub(super) diagram: Diagram,
    /// None: there is time without end.
    ends_at: Option<Instant>,
}

impl<'a> Space<'a> {
    pub(super) fn new(
        closed: &'a Closed<'a>,
        waiting: u8,
        limits: &Limits,
        begun: Instant,
    ) -> Self {
        let mut rules = closed.rules(waiting);
        let order = order(&rules);
        rules.reorder(&order, closed);
        let diagram = Diagram::new(rules.meanings.len() as u32, limits.nodes);
        Self {
            closed,
            rules,
            diagram,
            ends_at: begun.checked_add(limits.time),
        }
    }

    pub(super) fn empty(&self) -> Set {
        self.diagram.empty()
    }

    pub(super) fn initial(&self) -> Grown<Set> {
        let state = self.closed.initial();
        self.diagram.only(self.variables_of(state))
    }

    /// The variables that are true in a state.
    pub(super) fn variables_of(&self, state: &[u64]) -> impl Iterator<Item = u32> {
        let layout = self.closed.layout;
        { self.rules.meanings.iter().zip(0..) }
            .filter(move |&(meaning, _)| meaning.is_true(layout, state))
            .map(|(_, variable)| variable)
    }

    /// Tidies up, and sees whether there is time left.
    pub(super) fn breathe(&self) -> Grown<()> {
        self.diagram.tidy();
        if { self.ends_at }.is_some_and(|end| Instant::now() > end) {
            return Err(Exhausted::Time);
        }
        Ok(())
    }

    /// The states that fulfil all of this.
    pub(super) fn that(&self, set: &Set, tests: &[Literal]) -> Grown<Set> {
        let mut found = set.clone();
        for test in tests {
            found = match test.before {
                None => continue,
                Some(true) => found.with(test.variable)?,
                Some(false) => found.without(test.variable)?,
            };
            if found.is_empty() {
                break;
            }
        }
        Ok(found)
    }

    /// The states in which a rule applies.
    pub(super) fn applies(&self, set: &Set, rule: &Rule) -> Grown<Set> {
        self.that(set, &rule.guard)
    }

    /// Where a rule leads from these states.
    pub(super) fn after(&self, set: &Set, rule: &Rule) -> Grown<Set> {
        let mut at = forwards(set, &rule.guard)?;
        for stage in &rule.stages {
            if at.is_empty() {
                break;
            }
            at = self.any_way(&at, stage, forwards)?;
        }
        Ok(at)
    }

    /// From where a rule leads to these states.
    pub(super) fn before(&self, set: &Set, rule: &Rule) -> Grown<Set> {
        let mut at = set.clone();
        for stage in rule.stages.iter().rev() {
            if at.is_empty() {
                return Ok(at);
            }
            at = self.any_way(&at, stage, backwards)?;
        }
        backwards(&at, &rule.guard)
    }

    fn any_way(
        &self,
        set: &Set,
        stage: &[Vec<Literal>],
        way: fn(&Set, &[Literal]) -> Grown<Set>,
    ) -> Grown<Set> {
        let [only] = stage else {
            let mut all = self.empty();
            for literals in stage {
                all = all.union(&way(set, literals)?)?;
            }
            return Ok(all);
        };
        way(set, only)
    }
}

impl Set {
    /// The states with a variable that is not behind the first one, and without it.
    pub(super) fn split_at(&self, variable: u32, space: &Space<'_>) -> (Self, Self) {
        if self.top() == Some(variable) {
            self.split()
        } else {
            (space.empty(), self.clone())
        }
    }
}

fn forwards(set: &Set, literals: &[Literal]) -> Grown<Set> {
    let mut at = set.clone();
    for literal in literals {
        let variable = literal.variable;
        at = match (literal.before, literal.after) {
            (Some(true), true) => at.with(variable)?,
            (Some(true), false) => at.taken(variable)?,
            (Some(false), false) => at.without(variable)?,
            (Some(false), true) => at.without(variable)?.toggled(variable)?,
            (None, true) => at
                .without(variable)?
                .union(&at.taken(variable)?)?
                .toggled(variable)?,
            (None, false) => at.without(variable)?.union(&at.taken(variable)?)?,
        };
        if at.is_empty() {
            break;
        }
    }
    Ok(at)
}

fn backwards(set: &Set, literals: &[Literal]) -> Grown<Set> {
    let mut at = set.clone();
    for literal in literals {
        let variable = literal.variable;
        at = match (literal.before, literal.after) {
            (Some(true), true) => at.with(variable)?,
            (Some(true), false) => at.without(variable)?.toggled(variable)?,
            (Some(false), false) => at.without(variable)?,
            (Some(false), true) => at.taken(variable)?,
            (None, after) => {
                let without = match after {
                    true => at.taken(variable)?,
                    false => at.without(variable)?,
                };
                without.union(&without.toggled(variable)?)?
            }
        };
        if at.is_empty() {
            break;
        }
    }
    Ok(at)
}
