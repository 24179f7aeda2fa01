//! What both searches find out about a net as such.

use super::explored::Explored;
use super::graph::Backwards;
use super::never::Found;
use super::refusal::Trace;

/// How often a transition can fire (Murata 1989, Section IV.C).
#[derive(Clone, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum Liveness {
    /// Never (L0).
    Dead,
    /// At least once (L1); but after these steps, never again. They lead to a nearest deadlock if there is
    /// one, else to a nearest state from which the transition cannot fire any more.
    Dies(Trace),
    /// From every state, after some further steps (L4).
    Live,
}

/// Places that are marked and places that are empty, by their numbers.
pub(super) struct Target {
    pub(super) marked: Vec<u32>,
    pub(super) empty: Vec<u32>,
}

/// What is true of a net.
pub(super) struct Findings {
    pub(super) states: u128,
    pub(super) steps: u128,
    pub(super) deadlock: Option<Trace>,
    /// By transition.
    pub(super) liveness: Vec<Liveness>,
    /// By target.
    pub(super) reached: Vec<Option<Trace>>,
}

impl Explored<'_> {
    pub(super) fn findings(&self, targets: &[Target]) -> Findings {
        let layout = self.closed.layout;
        let mut goes_on = vec![false; self.store.len()];
        for &(from, _) in &self.edges {
            goes_on[from as usize] = true;
        }
        let stops = self.numbers().find(|&state| !goes_on[state as usize]);
        let deadlock = stops.map(|state| self.trace(state));
        let reached = targets.iter().map(|target| {
            let mut states = self.numbers();
            let state = states.find(|&state| {
                let is_marked = |&place: &u32| layout.is_marked(self.store.get(state), place);
                target.marked.iter().all(is_marked) && !target.empty.iter().any(is_marked)
            });
            state.map(|state| self.trace(state))
        });
        Findings {
            states: self.store.len() as u128,
            steps: self.edges.len() as u128,
            reached: reached.collect(),
            liveness: self.liveness(deadlock.as_ref()),
            deadlock,
        }
    }

    fn liveness(&self, deadlock: Option<&Trace>) -> Vec<Liveness> {
        let of_fired = |live: &dyn Fn(u32) -> Liveness| -> Vec<Liveness> {
            let fired = self.fired().iter().zip(0..);
            fired
                .map(|(&fired, transition)| match fired {
                    true => live(transition),
                    false => Liveness::Dead,
                })
                .collect()
        };
        if let Some(deadlock) = deadlock {
            return of_fired(&|_| Liveness::Dies(deadlock.clone()));
        }
        let graph = Backwards::new(self.store.len(), &self.edges);
        // If it can go back to the beginning from everywhere, what fires once can fire again.
        if graph.can_reach(std::iter::once(0)).iter().all(|&can| can) {
            return of_fired(&|_| Liveness::Live);
        }
        of_fired(&|transition| {
            let is_enabled = |&state: &u32| {
                let state = self.store.get(state);
                self.closed.is_enabled(state, transition) == Ok(true)
            };
            let can = graph.can_reach(self.numbers().filter(is_enabled));
            let lost = self.numbers().find(|&state| !can[state as usize]);
            lost.map_or(Liveness::Live, |state| Liveness::Dies(self.trace(state)))
        })
    }
}
