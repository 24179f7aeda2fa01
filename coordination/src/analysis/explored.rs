//! The search through all states, and what it proves.

use std::collections::BTreeSet;

use super::closed::{Closed, Move};
use super::graph;
use super::never::Found;
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
    fired: Vec<bool>,
    /// The flags that other parties set.
    set: BTreeSet<(u16, FlagId)>,
    /// The fault to be named, of those found so far.
    nearest: Option<Near>,
    /// Whether states are judged, or only listed.
    judges: bool,
}

/// A fault and how far away it is.
struct Near {
    distance: u32,
    rank: u8,
    state: u32,
    reason: Box<Reason>,
}

/// Remembers the nearer of two faults; of two at the same distance, the one that a state has as such,
/// then one of a step, then that there is no step.
fn note(nearest: &mut Option<Near>, distance: u32, state: u32, reason: Box<Reason>) {
    let rank = match *reason {
        Reason::Exclusion { .. } => 0,
        Reason::OutOfOrder { .. } => 1,
        Reason::Unsafe { .. } => 2,
        Reason::Overflow { .. } => 3,
        _ => 4,
    };
    let known = nearest.as_ref().map(|known| (known.distance, known.rank));
    if known.is_none_or(|known| (distance, rank) < known) {
        *nearest = Some(Near {
            distance,
            rank,
            state,
            reason,
        });
    }
}

fn too_large(what: &'static str, limit: u64) -> Box<Reason> {
    let proved = String::new();
    Box::new(Reason::TooLarge {
        what,
        limit,
        proved,
    })
}

impl<'a> Explored<'a> {
    /// Breadth first, so that the way found to each state is a shortest one. Gives the net back with the
    /// fault.
    pub(super) fn new(
        closed: Closed<'a>,
        limits: &Limits,
    ) -> Result<Self, (Box<Closed<'a>>, Fault)> {
        Self::explore(closed, limits, true)
    }

    /// As [`new`](Self::new), but the only faults are those after which it is not defined what happens: a
    /// second token, or an overflow.
    pub(super) fn listed(
        closed: Closed<'a>,
        limits: &Limits,
    ) -> Result<Self, (Box<Closed<'a>>, Fault)> {
        Self::explore(closed, limits, false)
    }

    fn explore(
        closed: Closed<'a>,
        limits: &Limits,
        judges: bool,
    ) -> Result<Self, (Box<Closed<'a>>, Fault)> {
        let mut explored = Self {
            store: Store::new(closed.layout.words),
            parents: vec![(0, None)],
            edges: Vec::new(),
            own: Vec::new(),
            fired: vec![false; closed.transitions()],
            set: BTreeSet::new(),
            nearest: None,
            judges,
            closed,
        };
        match explored.search(limits) {
            Ok(()) => Ok(explored),
            Err(fault) => Err((Box::new(explored.closed), fault)),
        }
    }

    fn search(&mut self, limits: &Limits) -> Result<(), Fault> {
        if limits.states == 0 {
            return Err((too_large("states", 0), None));
        }
        self.store.add(self.closed.initial());
        if self.judges
            && let Some(reason) = self.closed.fault(self.closed.initial())
        {
            return Err((reason, Some(self.trace(0))));
        }
        let (mut state, mut scratch) = (Vec::new(), Vec::new());
        let (mut next, mut looks) = (0, 0_u64);
        let (mut layer, mut distance) = (1, 0);
        while (next as usize) < self.store.len() {
            state.clear();
            state.extend_from_slice(self.store.get(next));
            let looked = self.expand(next, distance, &state, &mut scratch, limits);
            next += 1;
            let too_large = match looked {
                Err(reason) => Some(reason),
                Ok(more) => {
                    looks += more;
                    self.exceeds(looks, limits)
                }
            };
            // All states at this distance are known to be looked at, or no more can be.
            let is_last = next as usize == layer;
            if let Some(found) = self.nearest.take_if(|_| is_last || too_large.is_some()) {
                return Err((found.reason, Some(self.trace(found.state))));
            }
            if let Some(reason) = too_large {
                return Err((reason, None));
            }
            if is_last {
                (layer, distance) = (self.store.len(), distance + 1);
            }
        }
        Ok(())
    }

    fn exceeds(&self, looks: u64, limits: &Limits) -> Option<Box<Reason>> {
        if self.store.len() > limits.states {
            return Some(too_large("states", limits.states as u64));
        }
        if looks > limits.looks {
            return Some(too_large("transitions to look at", limits.looks));
        }
        None
    }

    /// Takes all steps from a state. An error says that there are too many.
    fn expand(
        &mut self,
        from: u32,
        distance: u32,
        state: &[u64],
        scratch: &mut Vec<u64>,
        limits: &Limits,
    ) -> Result<u64, Box<Reason>> {
        let Self {
            closed,
            store,
            parents,
            edges,
            own,
            fired,
            set,
            nearest,
            judges,
        } = self;
        let before = edges.len();
        let outcome = closed.steps(state, scratch, |step, to| {
            if edges.len() >= limits.steps {
                return Err(too_large("steps", limits.steps as u64));
            }
            match step {
                Move::Fire(transition) => fired[transition as usize] = true,
                Move::Set(protocol, flag) => drop(set.insert((protocol, flag))),
                _ => {}
            }
            let number = match store.find(to) {
                Some(number) => number,
                None if store.len() > limits.states => {
                    return Err(too_large("states", limits.states as u64));
                }
                None => {
                    let number = store.add(to);
                    parents.push((from, Some(step)));
                    if *judges && let Some(reason) = closed.fault(to) {
                        note(nearest, distance + 1, number, reason);
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
        let looks = match outcome {
            Ok(looks) => looks,
            Err(reason) if matches!(*reason, Reason::TooLarge { .. }) => return Err(reason),
            Err(reason) => {
                note(nearest, distance, from, reason);
                return Ok(1);
            }
        };
        if *judges && edges.len() == before && closed.end(state).is_none() {
            note(nearest, distance, from, Box::new(closed.deadlock(state)));
        }
        Ok(looks)
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
    pub(super) fn first_that_cannot_reach(
        &self,
        targets: impl Iterator<Item = u32>,
    ) -> Option<u32> {
        let can = graph::can_reach(self.store.len(), &self.edges, targets);
        self.numbers().find(|&state| !can[state as usize])
    }

    pub(super) fn numbers(&self) -> std::ops::Range<u32> {
        0..self.store.len() as u32
    }

    /// The steps that led to a state when it was first found.
    pub(super) fn trace(&self, state: u32) -> Trace {
        self.trace_within(state, usize::MAX).unwrap_or_default()
    }

    /// As [`trace`](Self::trace), if it is no longer than that.
    pub(super) fn trace_within(&self, mut state: u32, most: usize) -> Option<Trace> {
        let mut moves = Vec::new();
        while let (parent, Some(step)) = self.parents[state as usize] {
            if moves.len() == most {
                return None;
            }
            moves.push(step);
            state = parent;
        }
        let steps = moves.into_iter().rev().map(|step| self.closed.name(step));
        Some(Trace {
            steps: steps.collect(),
        })
    }
}

impl Found for Explored<'_> {
    fn closed(&self) -> &Closed<'_> {
        &self.closed
    }

    fn fired(&self) -> &[bool] {
        &self.fired
    }

    fn explain(&self, transition: usize) -> Dead {
        let lacks = |state: u32| self.closed.lacking(self.store.get(state), transition);
        let nearest = self.numbers().min_by_key(|&state| lacks(state).count());
        let nearest = nearest.unwrap_or(0);
        Dead {
            transition: self.closed.transition_name(transition).to_owned(),
            lacks: lacks(nearest).map(str::to_owned).collect(),
            nearest: self.trace(nearest),
        }
    }
}
