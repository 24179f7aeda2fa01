//! States by their distance from the initial one, and the steps to them.

use super::super::refusal::Trace;
use super::diagram::{Grown, Set};
use super::rules::{Literal, Rule};
use super::space::Space;
use super::sweep::{Sweep, Way};

/// As many layers as were asked for so far; the next follows from the last.
pub(super) struct Layers {
    layers: Vec<Set>,
    seen: Set,
}

impl Layers {
    pub(super) fn new(space: &Space<'_>) -> Grown<Self> {
        let initial = space.initial()?;
        Ok(Self {
            layers: vec![initial.clone()],
            seen: initial,
        })
    }

    /// The states at a distance; none if that is beyond the farthest.
    pub(super) fn at(&mut self, distance: usize, space: &Space<'_>) -> Grown<Option<&Set>> {
        while self.layers.len() <= distance {
            let Some(last) = self.layers.last().filter(|last| !last.is_empty()) else {
                return Ok(None);
            };
            let rules = space.rules.rules.iter();
            let next = Sweep::of_rules(space, Way::Forwards, rules).once(last)?;
            let next = next.minus(&self.seen)?;
            self.seen = self.seen.union(&next)?;
            self.layers.push(next);
        }
        Ok(self.layers.get(distance).filter(|layer| !layer.is_empty()))
    }

    /// One of the nearest of these states, and how to get there.
    pub(super) fn nearest(
        &mut self,
        targets: &Set,
        space: &Space<'_>,
    ) -> Grown<Option<(Vec<u64>, Trace)>> {
        for distance in 0.. {
            let Some(layer) = self.at(distance, space)? else {
                break;
            };
            if let Some(found) = layer.and(targets)?.any() {
                let trace = self.trace(distance, &found, space)?;
                return Ok(Some((space.state(&found), trace)));
            }
        }
        Ok(None)
    }

    /// The steps to a state at this distance, given by its true variables.
    pub(super) fn trace(&self, distance: usize, state: &[u32], space: &Space<'_>) -> Grown<Trace> {
        let mut steps = Vec::with_capacity(distance);
        let mut state = state.to_vec();
        for layer in self.layers[..distance].iter().rev() {
            let Some((rule, before)) = last_step(layer, &state, space)? else {
                break;
            };
            steps.push(space.closed.name(rule.step));
            state = before;
        }
        steps.reverse();
        Ok(Trace { steps })
    }
}

/// A rule that leads from the layer to this state, and from where.
fn last_step<'s>(
    layer: &Set,
    state: &[u32],
    space: &'s Space<'_>,
) -> Grown<Option<(&'s Rule, Vec<u32>)>> {
    let mut is_true = vec![false; space.rules.meanings.len()];
    for &variable in state {
        is_true[variable as usize] = true;
    }
    let fits = |literal: &Literal| is_true[literal.variable as usize] == literal.after;
    let here = space.diagram.only(state.iter().copied())?;
    for rule in &space.rules.rules {
        // A later stage may change what the guard has left.
        let is_last = |literal: &&Literal| {
            let mut later = rule.stages.iter().flatten().flatten();
            later.all(|other| other.variable != literal.variable)
        };
        if !rule.guard.iter().filter(is_last).all(fits) {
            continue;
        }
        let before = space.before(&here, rule)?.and(layer)?;
        if let Some(before) = before.any() {
            return Ok(Some((rule, before)));
        }
    }
    Ok(None)
}
