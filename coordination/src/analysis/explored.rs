//! The search through all states, and what it proves.

use std::collections::BTreeSet;

use super::closed::{Closed, Move};
use super::graph;
use super::refusal::{Dead, Reason, Trace};
use super::report::Warning;
use super::store::Store;
use super::usage::Limits;
use crate::protocol::FlagId;

/// What is wrong, and the way there.
pub(super) type Fault = (Box<Reason>, Option<Trace>);

/// All states, and the steps between them.
pub(super) struct Explored<'a> {
    pub(super) closed: Closed<'a>,
    pub(super) store: Store,
    /// By state: the one it was first reached from, and how.
    parents: Vec<(u32, Option<Move>)>,
    pub(super) edges: Vec<(u32, u32)>,
    /// The steps that the net takes without news from outside.
    own: Vec<(u32, u32)>,
    /// By transition.
    pub(super) fired: Vec<bool>,
    /// The flags that other parties set.
    set: BTreeSet<(u16, FlagId)>,
}

impl<'a> Explored<'a> {
    /// Breadth first, so that the way found to each state is a shortest one.
    pub(super) fn new(closed: Closed<'a>, limits: &Limits) -> Result<Self, Fault> {
        let mut explored = Self {
            store: Store::new(closed.layout.words),
            parents: vec![(0, None)],
            edges: Vec::new(),
            own: Vec::new(),
            fired: vec![false; closed.transitions()],
            set: BTreeSet::new(),
            closed,
        };
        explored.store.add(explored.closed.initial());
        explored.examine(0, explored.closed.initial())?;
        let (mut state, mut scratch) = (Vec::new(), Vec::new());
        let (mut next, mut looks) = (0, 0_u64);
        while (next as usize) < explored.store.len() {
            state.clear();
            state.extend_from_slice(explored.store.get(next));
            looks += explored.expand(next, &state, &mut scratch, limits)?;
            let too_many = |what, limit| (Box::new(Reason::TooLarge { what, limit }), None);
            if explored.store.len() > limits.states {
                return Err(too_many("states", limits.states as u64));
            }
            if looks > limits.looks {
                return Err(too_many("transitions to look at", limits.looks));
            }
            next += 1;
        }
        Ok(explored)
    }

    fn expand(
        &mut self,
        from: u32,
        state: &[u64],
        scratch: &mut Vec<u64>,
        limits: &Limits,
    ) -> Result<u64, Fault> {
        let Self {
            closed,
            store,
            parents,
            edges,
            own,
            fired,
            set,
        } = self;
        let before = edges.len();
        let mut fault_at = from;
        let outcome = closed.steps(state, scratch, |step, to| {
            if edges.len() >= limits.steps {
                let (what, limit) = ("steps", limits.steps as u64);
                return Err(Box::new(Reason::TooLarge { what, limit }));
            }
            match step {
                Move::Fire(transition) => fired[transition as usize] = true,
                Move::Set(protocol, flag) => drop(set.insert((protocol, flag))),
                _ => {}
            }
            let number = match store.find(to) {
                Some(number) => number,
                None if store.len() > limits.states => {
                    let (what, limit) = ("states", limits.states as u64);
                    return Err(Box::new(Reason::TooLarge { what, limit }));
                }
                None => {
                    let number = store.add(to);
                    parents.push((from, Some(step)));
                    if let Some(reason) = closed.fault(to) {
                        fault_at = number;
                        return Err(reason);
                    }
                    number
                }
            };
            edges.push((from, number));
            if step.is_own() {
                own.push((from, number));
            }
            Ok(())
        });
        let looks = outcome.map_err(|reason| {
            let trace = match *reason {
                Reason::TooLarge { .. } => None,
                _ => Some(self.trace(fault_at)),
            };
            (reason, trace)
        })?;
        if self.edges.len() == before && self.closed.end(state).is_none() {
            let reason = Reason::Deadlock {
                marked: self.closed.marked(state),
                missed: self.closed.missed(state),
            };
            return Err((Box::new(reason), Some(self.trace(from))));
        }
        Ok(looks)
    }

    fn examine(&self, number: u32, state: &[u64]) -> Result<(), Fault> {
        match self.closed.fault(state) {
            Some(reason) => Err((reason, Some(self.trace(number)))),
            None => Ok(()),
        }
    }

    /// What only the whole graph tells: the ends reached, and warnings.
    pub(super) fn prove(&self) -> Result<(Vec<String>, Vec<Warning>), Fault> {
        let mut ends = vec![false; self.closed.end_names().count()];
        let mut targets = Vec::new();
        for number in self.numbers() {
            if let Some(end) = self.closed.end(self.store.get(number)) {
                ends[end] = true;
                targets.push(number);
            }
        }
        let mut warnings = Vec::new();
        if ends.is_empty() {
            warnings.push(Warning::NoEnds);
            self.prove_runs_complete()?;
        } else if let Some(lost) = self.first_that_cannot_reach(targets.into_iter()) {
            let marked = self.closed.marked(self.store.get(lost));
            return Err((
                Box::new(Reason::Livelock { marked }),
                Some(self.trace(lost)),
            ));
        }
        let set = self.set.iter();
        for (protocol, flag) in set.filter_map(|&(number, flag)| self.closed.unread(number, flag)) {
            let (protocol, flag) = (protocol.to_owned(), flag.to_owned());
            warnings.push(Warning::Unread { protocol, flag });
        }
        if let Some(state) = graph::first_endless(self.store.len(), &self.own) {
            let trace = self.trace(state);
            if !self.closed.allows_endless() {
                return Err((Box::new(Reason::Endless), Some(trace)));
            }
            warnings.push(Warning::NeverRests { trace });
        }
        let names = self.closed.end_names().zip(ends);
        let reached = names.filter(|(_, reached)| *reached);
        Ok((reached.map(|(name, _)| name.to_owned()).collect(), warnings))
    }

    fn prove_runs_complete(&self) -> Result<(), Fault> {
        for (number, used) in self.closed.protocols().iter().enumerate() {
            let between = self
                .numbers()
                .filter(|&state| self.closed.is_between_runs(self.store.get(state), number));
            if let Some(lost) = self.first_that_cannot_reach(between) {
                let state = self.store.get(lost);
                let reason = Reason::Unfinished {
                    protocol: used.name.clone(),
                    missed: self.closed.missing(state, number),
                    marked: self.closed.marked(state),
                };
                return Err((Box::new(reason), Some(self.trace(lost))));
            }
        }
        Ok(())
    }

    /// States are numbered by their distance, so the first is a nearest.
    fn first_that_cannot_reach(&self, targets: impl Iterator<Item = u32>) -> Option<u32> {
        let can = graph::can_reach(self.store.len(), &self.edges, targets);
        self.numbers().find(|&state| !can[state as usize])
    }

    /// A transition that did not fire, with the first of the states in which it comes nearest.
    pub(super) fn explain(&self, transition: usize) -> Dead {
        let lacks = |state: u32| self.closed.lacking(self.store.get(state), transition);
        let nearest = self.numbers().min_by_key(|&state| lacks(state).count());
        let nearest = nearest.unwrap_or(0);
        Dead {
            transition: self.closed.transition_name(transition).to_owned(),
            lacks: lacks(nearest).map(str::to_owned).collect(),
            nearest: self.trace(nearest),
        }
    }

    fn numbers(&self) -> std::ops::Range<u32> {
        0..self.store.len() as u32
    }

    /// The steps that led to a state when it was first found.
    fn trace(&self, mut state: u32) -> Trace {
        let mut steps = Vec::new();
        while let (parent, Some(step)) = self.parents[state as usize] {
            steps.push(self.closed.name(step));
            state = parent;
        }
        steps.reverse();
        Trace { steps }
    }
}
