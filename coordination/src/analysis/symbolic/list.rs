//! What is true of a net as such, found in all states at once.

use super::super::closed::{Closed, Move};
use super::super::explored::Fault;
use super::super::findings::{Deaths, Findings, Liveness, Target};
use super::super::refusal::Trace;
use super::super::usage::Limits;
use super::deep::{Looked, deep, in_spaces};
use super::diagram::{Counts, Grown, Set};
use super::layers::Ways;
use super::space::Space;

/// Looks at all states; the only faults are those after which it is not defined what happens.
pub(in crate::analysis) fn list(
    closed: &Closed<'_>,
    limits: &Limits,
    targets: &[Target],
) -> Result<Findings, Fault> {
    deep(limits, || {
        in_spaces(closed, limits, |space| find(space, targets, limits))
    })
}

fn find(space: &Space<'_>, targets: &[Target], limits: &Limits) -> Grown<Looked<Findings>> {
    let all = space.reach(&space.initial()?)?;
    let mut ways = Ways::new(all.clone(), space)?;
    let trapped = space.trapped(&all)?;
    if trapped.waits {
        return Ok(Looked::Waits);
    }
    if let Some((state, trace)) = ways.nearest(&[trapped.second, trapped.overflows], space)? {
        let reason = space.trap(&state)?;
        return Ok(Looked::Fault((reason, Some(trace))));
    }
    let mut nearest = |set: Set| -> Grown<Option<Trace>> {
        if set.is_empty() {
            return Ok(None);
        }
        let found = ways.nearest(&[set], space)?;
        Ok(found.map(|(_, trace)| trace))
    };
    let blocked = space.blocked(&all)?;
    let deadlock = nearest(blocked)?;
    let mut reached = Vec::with_capacity(targets.len());
    for target in targets {
        reached.push(nearest(space.having(&all, target)?)?);
    }
    let (mut counts, mut steps) = (Counts::default(), 0_u128);
    let mut fires: Vec<Option<Set>> = vec![None; space.closed.transitions()];
    for rule in &space.rules.rules {
        let applies = space.applies(&all, rule)?;
        steps = steps.saturating_add(applies.count(&mut counts));
        if let Move::Fire(transition) = rule.step
            && !applies.is_empty()
        {
            fires[transition as usize] = Some(applies);
        }
        space.breathe()?;
    }
    let returns = deadlock.is_none() && {
        let home = space.can_reach(&all, &space.initial()?, |_| true)?;
        home == all
    };
    let mut liveness = Vec::with_capacity(fires.len());
    let (mut deaths, mut room) = (Deaths::default(), limits.steps);
    for (transition, applies) in fires.into_iter().enumerate() {
        liveness.push(match (applies, &deadlock) {
            (None, _) => Liveness::Dead,
            (Some(_), Some(_)) => Liveness::Dies,
            // If it can go back to the beginning from everywhere, what fires once can fire again.
            (Some(_), None) if returns => Liveness::Live,
            (Some(applies), None) => {
                let can = space.can_reach(&all, &applies, |_| true)?;
                let lost = all.minus(&can)?;
                if lost.is_empty() {
                    Liveness::Live
                } else {
                    let way = if room > 0 { nearest(lost)? } else { None };
                    if let Some(way) = way.filter(|way| way.steps.len() <= room) {
                        room -= way.steps.len();
                        deaths.add(transition, way);
                    }
                    Liveness::Dies
                }
            }
        });
    }
    Ok(Looked::All(Findings {
        states: all.count(&mut counts),
        steps,
        deadlock,
        liveness,
        deaths,
        reached,
    }))
}

impl Space<'_> {
    /// The states in which these places are marked and those are empty.
    fn having(&self, set: &Set, target: &Target) -> Grown<Set> {
        let variable = |place: &u32| self.rules.numbers.places[*place as usize];
        let mut found = set.clone();
        for place in &target.marked {
            found = found.with(variable(place))?;
        }
        for place in &target.empty {
            found = found.without(variable(place))?;
        }
        Ok(found)
    }
}
