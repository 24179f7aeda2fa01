//! What both searches find out about a net as such.

use super::explored::Explored;
use super::refusal::Trace;
use super::usage::Limits;

/// How often a transition can fire (Murata 1989, Section IV.C).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub enum Liveness {
    /// Never (L0).
    Dead,
    /// At least once (L1); but after some steps, never again:
    /// [`Properties::dies_after`](super::Properties::dies_after).
    Dies,
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
    pub(super) deaths: Deaths,
    /// By target.
    pub(super) reached: Vec<Option<Trace>>,
}

/// The ways to where transitions die without a deadlock. Each is kept once, and all together have no more steps
/// than a limit: every transition of a long net can die somewhere else.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct Deaths {
    ways: Vec<Trace>,
    /// By transition, as far as there is a way to name; the number of its way.
    of: Vec<Option<u32>>,
}

impl Deaths {
    /// The way after which a transition never fires again.
    pub(super) fn way(&self, transition: usize) -> Option<&Trace> {
        let way = (*self.of.get(transition)?)?;
        self.ways.get(way as usize)
    }

    /// Names the way of a transition; its number, to name it for others too.
    pub(super) fn add(&mut self, transition: usize, way: Trace) -> u32 {
        let number = self.ways.len() as u32;
        self.ways.push(way);
        self.add_known(transition, number);
        number
    }

    /// Names a way that was added before.
    pub(super) fn add_known(&mut self, transition: usize, way: u32) {
        if self.of.len() <= transition {
            self.of.resize(transition + 1, None);
        }
        self.of[transition] = Some(way);
    }
}

impl Explored<'_> {
    pub(super) fn findings(&self, targets: &[Target], limits: &Limits) -> Findings {
        let layout = self.closed.layout;
        let mut goes_on = vec![false; self.store.len()];
        for &(from, _) in &self.edges {
            goes_on[from as usize] = true;
        }
        let stops = self.numbers().find(|&state| !goes_on[state as usize]);
        let reached = targets.iter().map(|target| {
            let mut states = self.numbers();
            let state = states.find(|&state| {
                let is_marked = |&place: &u32| layout.is_marked(self.store.get(state), place);
                target.marked.iter().all(is_marked) && !target.empty.iter().any(is_marked)
            });
            state.map(|state| self.trace(state))
        });
        let (liveness, deaths) = self.liveness(stops.is_some(), limits);
        Findings {
            states: self.store.len() as u128,
            steps: self.edges.len() as u128,
            reached: reached.collect(),
            liveness,
            deaths,
            deadlock: stops.map(|state| self.trace(state)),
        }
    }
}
