//! Which transitions stay alive, of a net whose states are all listed.
//!
//! A net without deadlock ends up in one of the components of its graph of states that no step leaves, and can
//! go round in it for ever. So a transition is live if it can fire in each of these. Where the others die is
//! found for 64 of them at a time.

use std::collections::HashMap;

use super::closed::Move;
use super::components::Components;
use super::explored::Explored;
use super::findings::{Deaths, Liveness};
use super::never::Found;
use super::usage::Limits;

/// Transitions that are looked at together: one bit each.
const TOGETHER: usize = 64;

impl Explored<'_> {
    /// By transition, and where those die that do, which is known of all if the net stops somewhere.
    pub(super) fn liveness(&self, stops: bool, limits: &Limits) -> (Vec<Liveness>, Deaths) {
        let fired = self.fired().iter();
        let Some(components) = (!stops).then(|| Components::new(self.store.len(), &self.edges))
        else {
            let dies = fired.map(|&fired| [Liveness::Dead, Liveness::Dies][usize::from(fired)]);
            return (dies.collect(), Deaths::default());
        };
        let stays = self.fires_for_ever(&components);
        let liveness: Vec<Liveness> = { fired.zip(stays) }
            .map(|(&fired, stays)| match (fired, stays) {
                (false, _) => Liveness::Dead,
                (true, false) => Liveness::Dies,
                (true, true) => Liveness::Live,
            })
            .collect();
        let deaths = self.deaths(&components, &liveness, limits);
        (liveness, deaths)
    }

    /// For each transition, whether it can fire in every component that no step leaves.
    fn fires_for_ever(&self, components: &Components) -> Vec<bool> {
        let last = components.last();
        let mut fires = vec![0; self.fired().len()];
        // The last component in which it fires, of those looked at.
        let mut found = vec![None; self.fired().len()];
        let mut scratch = Vec::new();
        for &state in &components.order {
            let component = components.of[state as usize];
            if !last[component as usize] {
                continue;
            }
            // No step of it is at fault, as all have been taken before.
            let words = self.store.get(state);
            let _ = self.closed.steps(words, &mut scratch, |step, _| {
                if let Move::Fire(transition) = step
                    && found[transition as usize].replace(component) != Some(component)
                {
                    fires[transition as usize] += 1;
                }
                Ok(())
            });
        }
        let all = last.iter().filter(|&&is_last| is_last).count();
        fires.into_iter().map(|count| count == all).collect()
    }

    /// For those that die a nearest state from which they cannot fire, within the limits: as many looks again as
    /// the states took, and as many steps of ways as there may be between states.
    fn deaths(&self, components: &Components, liveness: &[Liveness], limits: &Limits) -> Deaths {
        let dies = |&transition: &usize| liveness[transition] == Liveness::Dies;
        let dying: Vec<usize> = (0..liveness.len()).filter(dies).collect();
        let mut deaths = Deaths::default();
        let (mut looks, mut room) = (0_u64, limits.steps);
        let mut ways: HashMap<u32, u32> = HashMap::new();
        for some in dying.chunks(TOGETHER) {
            let more = self.store.len() * (some.len() + 2) + self.edges.len();
            looks = looks.saturating_add(more as u64);
            if looks > limits.looks {
                break;
            }
            for (&transition, state) in some.iter().zip(self.lost(components, some)) {
                let Some(state) = state else { continue };
                if let Some(&way) = ways.get(&state) {
                    deaths.add_known(transition, way);
                } else if let Some(way) = self.trace_within(state, room) {
                    room -= way.steps.len();
                    ways.insert(state, deaths.add(transition, way));
                }
            }
        }
        deaths
    }

    /// For each of up to [`TOGETHER`] transitions, the first state from which it cannot fire any more.
    fn lost(&self, components: &Components, transitions: &[usize]) -> Vec<Option<u32>> {
        // By component, one bit for each transition that can still fire.
        let mut can = vec![0_u64; components.count];
        for &state in &components.order {
            let own = components.of[state as usize] as usize;
            let words = self.store.get(state);
            for (bit, &transition) in transitions.iter().enumerate() {
                let is_known = can[own] >> bit & 1 == 1;
                if !is_known && self.closed.is_enabled(words, transition as u32) == Ok(true) {
                    can[own] |= 1 << bit;
                }
            }
            for &(_, to) in components.steps_from(state, &self.edges) {
                can[own] |= can[components.of[to as usize] as usize];
            }
        }
        let mut lost = vec![None; transitions.len()];
        let mut left = transitions.len();
        for state in self.numbers() {
            let can = can[components.of[state as usize] as usize];
            for (bit, lost) in lost.iter_mut().enumerate() {
                if can >> bit & 1 == 0 && lost.is_none() {
                    *lost = Some(state);
                    left -= 1;
                }
            }
            if left == 0 {
                break;
            }
        }
        lost
    }
}
