//! The steps of a closed net as rules over true and false.

use super::super::state::Layout;
use super::net::{Closed, Move};

/// What a rule asks of a variable, and what it makes of it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::analysis) struct Literal {
    pub(in crate::analysis) variable: u32,
    /// None if it may be either.
    pub(in crate::analysis) before: Option<bool>,
    pub(in crate::analysis) after: bool,
}

impl Literal {
    /// It is so, and stays so.
    pub(in crate::analysis) fn is(variable: u32, value: bool) -> Self {
        Self::turns(variable, value, value)
    }

    pub(in crate::analysis) fn turns(variable: u32, before: bool, after: bool) -> Self {
        let before = Some(before);
        Self {
            variable,
            before,
            after,
        }
    }

    pub(in crate::analysis) fn becomes(variable: u32, after: bool) -> Self {
        Self {
            variable,
            before: None,
            after,
        }
    }
}

/// A step: its guard, and then stages, of each of which one alternative applies.
#[derive(Debug)]
pub(in crate::analysis) struct Rule {
    pub(in crate::analysis) step: Move,
    pub(in crate::analysis) guard: Vec<Literal>,
    pub(in crate::analysis) stages: Vec<Vec<Vec<Literal>>>,
}

/// A fault that a state has because of a step that it would take.
#[derive(Debug)]
pub(in crate::analysis) struct Trap {
    pub(in crate::analysis) kind: TrapKind,
    pub(in crate::analysis) tests: Vec<Literal>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::analysis) enum TrapKind {
    /// This transition would put a second token into a place.
    Unsafe { transition: u32, place: u32 },
    /// One event too many would wait for this source.
    Overflow { source: u32 },
}

/// What a variable stands for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(in crate::analysis) enum Meaning {
    Marked(u32),
    /// This protocol is at this position.
    At(u32, u32),
    /// At least so many events wait, by counter.
    Waiting(u32, u8),
}

impl Meaning {
    /// Whether it holds in a state.
    pub(in crate::analysis) fn is_true(self, layout: Layout, state: &[u64]) -> bool {
        match self {
            Self::Marked(place) => layout.is_marked(state, place),
            Self::At(protocol, position) => {
                u32::from(layout.position(state, protocol as usize)) == position
            }
            Self::Waiting(counter, count) => layout.waiting(state, counter as usize) >= count,
        }
    }
}

/// A closed net over variables.
#[derive(Debug)]
pub(in crate::analysis) struct Rules {
    pub(in crate::analysis) rules: Vec<Rule>,
    pub(in crate::analysis) traps: Vec<Trap>,
    /// By variable.
    pub(in crate::analysis) meanings: Vec<Meaning>,
    pub(in crate::analysis) numbers: Numbers,
    /// How many events may wait for a source.
    pub(in crate::analysis) waiting: u8,
}

/// The variables of the parts of a state.
#[derive(Clone, Debug)]
pub(in crate::analysis) struct Numbers {
    pub(in crate::analysis) places: Vec<u32>,
    pub(in crate::analysis) positions: Vec<Vec<u32>>,
    /// By counter, and by how many wait less one.
    pub(in crate::analysis) waiting: Vec<Vec<u32>>,
}

impl Numbers {
    pub(in crate::analysis) fn of(meanings: &[Meaning], closed: &Closed<'_>) -> Self {
        let counters = closed.counters().iter().flatten().count();
        let mut numbers = Self {
            places: vec![0; closed.counters().len()],
            positions: vec![Vec::new(); closed.protocols().len()],
            waiting: vec![Vec::new(); counters],
        };
        let put = |list: &mut Vec<u32>, at: usize, variable| {
            list.resize(list.len().max(at + 1), 0);
            list[at] = variable;
        };
        for (&meaning, variable) in meanings.iter().zip(0..) {
            match meaning {
                Meaning::Marked(place) => numbers.places[place as usize] = variable,
                Meaning::At(protocol, position) => put(
                    &mut numbers.positions[protocol as usize],
                    position as usize,
                    variable,
                ),
                Meaning::Waiting(counter, count) => put(
                    &mut numbers.waiting[counter as usize],
                    usize::from(count) - 1,
                    variable,
                ),
            }
        }
        numbers
    }
}

impl Rules {
    /// Puts the variables into another order: `order[new]` is the old number.
    pub(in crate::analysis) fn reorder(&mut self, order: &[u32], closed: &Closed<'_>) {
        let mut new = vec![0; order.len()];
        for (&old, number) in order.iter().zip(0..) {
            new[old as usize] = number;
        }
        let literals = { self.rules.iter_mut() }
            .flat_map(|rule| {
                { rule.guard.iter_mut() }.chain(rule.stages.iter_mut().flatten().flatten())
            })
            .chain(self.traps.iter_mut().flat_map(|trap| &mut trap.tests));
        for literal in literals {
            literal.variable = new[literal.variable as usize];
        }
        for list in { self.rules.iter_mut() }
            .flat_map(|rule| {
                [&mut rule.guard]
                    .into_iter()
                    .chain(rule.stages.iter_mut().flatten())
            })
            .chain(self.traps.iter_mut().map(|trap| &mut trap.tests))
        {
            // What is asked to be true first: that leaves the fewest states.
            list.sort_by_key(|literal| (literal.before != Some(true), literal.variable));
        }
        let meanings = order.iter().map(|&old| self.meanings[old as usize]);
        self.meanings = meanings.collect();
        self.numbers = Numbers::of(&self.meanings, closed);
    }
}

impl Rule {
    pub(in crate::analysis) fn literals(&self) -> impl Iterator<Item = &Literal> {
        self.guard
            .iter()
            .chain(self.stages.iter().flatten().flatten())
    }
}
