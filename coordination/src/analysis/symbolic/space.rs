//! Sets of states of a closed net, and where its rules lead from them.

use std::time::Instant;

use super::super::closed::Closed;
use super::super::closed::rule::{Literal, Rule, Rules};
use super::super::usage::Limits;
use super::diagram::{Diagram, Exhausted, Grown, Set};
use super::order::order;

/// So many literals are looked at between two looks at the clock.
const BREATH: usize = 8;

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
    ) -> Grown<Self> {
        // A literal takes no more than a node.
        let rules = closed.rules(waiting, limits.nodes);
        let mut rules = rules.ok_or(Exhausted::Nodes)?;
        let order = order(&rules);
        rules.reorder(&order, closed);
        let diagram = Diagram::new(rules.meanings.len() as u32, limits.nodes);
        Ok(Self {
            closed,
            rules,
            diagram,
            ends_at: begun.checked_add(limits.time),
        })
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
        self.one_by_one(set, tests, |found, test| match test.before {
            None => Ok(found.clone()),
            Some(true) => found.with(test.variable),
            Some(false) => found.without(test.variable),
        })
    }

    /// The states in which a rule applies.
    pub(super) fn applies(&self, set: &Set, rule: &Rule) -> Grown<Set> {
        self.that(set, &rule.guard)
    }

    /// Where a rule leads from these states.
    pub(super) fn after(&self, set: &Set, rule: &Rule) -> Grown<Set> {
        let mut at = self.forwards(set, &rule.guard)?;
        for stage in &rule.stages {
            if at.is_empty() {
                break;
            }
            at = self.any_way(&at, stage, Self::forwards)?;
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
            at = self.any_way(&at, stage, Self::backwards)?;
        }
        self.backwards(&at, &rule.guard)
    }

    fn any_way(
        &self,
        set: &Set,
        stage: &[Vec<Literal>],
        way: fn(&Self, &Set, &[Literal]) -> Grown<Set>,
    ) -> Grown<Set> {
        let [only] = stage else {
            let mut all = self.empty();
            for literals in stage {
                all = all.union(&way(self, set, literals)?)?;
            }
            return Ok(all);
        };
        way(self, set, only)
    }

    fn forwards(&self, set: &Set, literals: &[Literal]) -> Grown<Set> {
        self.one_by_one(set, literals, |at, literal| {
            let variable = literal.variable;
            match (literal.before, literal.after) {
                (Some(true), true) => at.with(variable),
                (Some(true), false) => at.taken(variable),
                (Some(false), false) => at.without(variable),
                (Some(false), true) => at.without(variable)?.toggled(variable),
                (None, true) => { at.without(variable)? }
                    .union(&at.taken(variable)?)?
                    .toggled(variable),
                (None, false) => at.without(variable)?.union(&at.taken(variable)?),
            }
        })
    }

    fn backwards(&self, set: &Set, literals: &[Literal]) -> Grown<Set> {
        self.one_by_one(set, literals, |at, literal| {
            let variable = literal.variable;
            match (literal.before, literal.after) {
                (Some(true), true) => at.with(variable),
                (Some(true), false) => at.without(variable)?.toggled(variable),
                (Some(false), false) => at.without(variable),
                (Some(false), true) => at.taken(variable),
                (None, after) => {
                    let without = match after {
                        true => at.taken(variable)?,
                        false => at.without(variable)?,
                    };
                    without.union(&without.toggled(variable)?)
                }
            }
        })
    }

    /// What is left of a set after one literal after another. A rule may have thousands, each a walk through the whole diagram.
    fn one_by_one(
        &self,
        set: &Set,
        literals: &[Literal],
        way: impl Fn(&Set, &Literal) -> Grown<Set>,
    ) -> Grown<Set> {
        let mut at = set.clone();
        for (number, literals) in literals.chunks(BREATH).enumerate() {
            if number > 0 {
                self.breathe()?;
            }
            for literal in literals {
                at = way(&at, literal)?;
                if at.is_empty() {
                    return Ok(at);
                }
            }
        }
        Ok(at)
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
