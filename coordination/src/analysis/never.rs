//! What never happens: transitions that do not fire, ends that are not reached.

use std::collections::{HashMap, HashSet};

use super::closed::Closed;
use super::proof::Proof;
use super::refusal::{Dead, Reason, Trace};

/// How many transitions that do not fire are explained, in each situation.
pub(super) const EXPLAINED: usize = 32;

/// What a search through all states has found.
pub(super) trait Found {
    fn closed(&self) -> &Closed<'_>;
    /// Whether it fires, by transition.
    fn fired(&self) -> &[bool];
    /// A transition that did not fire, with a nearest of the states in which it lacks least.
    fn explain(&self, transition: usize) -> Dead;
}

/// What never happens in any situation. Situations may differ in what they leave out, so all goes
/// by names.
#[derive(Default)]
pub(super) struct Never {
    /// All transitions, sinks and ends, perhaps repeatedly.
    transitions: Vec<String>,
    sinks: Vec<String>,
    ends: Vec<String>,
    /// Transitions that fired, and sinks that were marked.
    fired: HashSet<String>,
    marked: HashSet<String>,
    /// Why transitions did not fire in the first situation that has them.
    explained: HashMap<String, Dead>,
}

impl Never {
    pub(super) fn add(&mut self, found: &impl Found) {
        let closed = found.closed();
        let mut left = EXPLAINED;
        for (transition, &fired) in found.fired().iter().enumerate() {
            let name = closed.transition_name(transition);
            let sinks = closed.sinks_of(transition).map(str::to_owned);
            if fired {
                self.fired.insert(name.to_owned());
                self.marked.extend(sinks);
            } else {
                self.transitions.push(name.to_owned());
                self.sinks.extend(sinks);
                if left > 0 && !self.fired.contains(name) && !self.explained.contains_key(name) {
                    left -= 1;
                    self.explained
                        .insert(name.to_owned(), found.explain(transition));
                }
            }
        }
        self.ends.extend(closed.end_names().map(str::to_owned));
    }

    pub(super) fn reason(mut self, proofs: &[Proof]) -> Option<Reason> {
        let mut dead = Vec::new();
        for transition in self.transitions {
            // Each name once.
            if self.fired.insert(transition.clone()) {
                dead.push(self.explained.remove(&transition).unwrap_or(Dead {
                    transition,
                    lacks: Vec::new(),
                    nearest: Trace::default(),
                }));
            }
        }
        if !dead.is_empty() {
            self.sinks.retain(|sink| self.marked.insert(sink.clone()));
            return Some(Reason::DeadTransitions {
                transitions: dead,
                sinks: self.sinks,
            });
        }
        let reached = |end: &String| proofs.iter().any(|proof| proof.report().ends.contains(end));
        let end = self.ends.into_iter().find(|end| !reached(end))?;
        Some(Reason::EndUnreached { end })
    }
}
