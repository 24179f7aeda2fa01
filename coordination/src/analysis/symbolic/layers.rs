//! States by their distance, and the shortest ways to them.

use super::super::closed::rule::{Literal, Rule};
use super::super::refusal::Trace;
use super::diagram::{Grown, Set};
use super::space::Space;
use super::sweep::{Sweep, Way};

/// States by their distance: as many layers as were asked for so far, the last perhaps empty.
struct Layers {
    layers: Vec<Set>,
    seen: Set,
}

impl Layers {
    fn new(first: Set) -> Self {
        Self {
            layers: vec![first.clone()],
            seen: first,
        }
    }

    /// Adds the next layer; false if there is none.
    fn add(&mut self, way: Way, within: &Set, space: &Space<'_>) -> Grown<bool> {
        let last = &self.layers[self.layers.len() - 1];
        let rules = space.rules.rules.iter();
        let next = Sweep::of_rules(space, way, rules).once(last)?;
        let next = next.minus(&self.seen)?.and(within)?;
        self.seen = self.seen.union(&next)?;
        let is_new = !next.is_empty();
        self.layers.push(next);
        Ok(is_new)
    }
}

/// Ways from the initial state, searched from both ends at once: layers near an end are small.
pub(super) struct Ways {
    ahead: Layers,
    /// All states.
    all: Set,
}

impl Ways {
    /// `all` are the states that there are.
    pub(super) fn new(all: Set, space: &Space<'_>) -> Grown<Self> {
        let ahead = Layers::new(space.initial()?);
        Ok(Self { ahead, all })
    }

    /// A nearest one of these states by its true variables, and how to get there. Of several kinds of
    /// states that are equally near, the first is taken.
    pub(super) fn nearest(
        &mut self,
        kinds: &[Set],
        space: &Space<'_>,
    ) -> Grown<Option<(Vec<u32>, Trace)>> {
        let mut targets = space.empty();
        for kind in kinds {
            targets = targets.union(&kind.and(&self.all)?)?;
        }
        let mut back = Layers::new(targets);
        let mut ahead = 0;
        let meeting = loop {
            let (near, far) = (
                &self.ahead.layers[ahead],
                &back.layers[back.layers.len() - 1],
            );
            let meeting = near.and(far)?;
            if !meeting.is_empty() {
                break meeting;
            }
            let is_known = ahead + 1 < self.ahead.layers.len();
            let goes_on = if is_known {
                ahead += 1;
                !self.ahead.layers[ahead].is_empty()
            } else if near.nodes() <= far.nodes() {
                ahead += 1;
                self.ahead.add(Way::Forwards, &self.all, space)?
            } else {
                back.add(Way::Backwards, &self.all, space)?
            };
            if !goes_on {
                return Ok(None);
            }
        };
        let mut way = self.ahead.layers[..ahead].to_vec();
        way.push(meeting);
        back.layers.pop();
        for layer in back.layers.iter().rev() {
            let last = &way[way.len() - 1];
            let rules = space.rules.rules.iter();
            let next = Sweep::of_rules(space, Way::Forwards, rules).once(last)?;
            way.push(next.and(layer)?);
        }
        let Some(ends) = way.pop() else {
            return Ok(None);
        };
        for kind in kinds {
            if let Some(state) = ends.and(kind)?.any() {
                let trace = trace(&way, &state, space)?;
                return Ok(Some((state, trace)));
            }
        }
        Ok(None)
    }
}

/// The steps through these layers to a state behind the last, given by its true variables.
fn trace(layers: &[Set], state: &[u32], space: &Space<'_>) -> Grown<Trace> {
    let mut steps = Vec::with_capacity(layers.len());
    let mut state = state.to_vec();
    for layer in layers.iter().rev() {
        let Some((rule, before)) = last_step(layer, &state, space)? else {
            break;
        };
        steps.push(space.closed.name(rule.step));
        state = before;
    }
    steps.reverse();
    Ok(Trace { steps })
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
