//! What coordinations tell machines, and want to know of them.

use std::collections::BTreeMap;
use std::sync::Arc;

use super::route::Bound;
use crate::nets::{Kind, Plan, Script};

/// Events and outputs of machines, by number.
pub(super) type Words<'a> = BTreeMap<&'a str, u16>;

/// Numbers for all that coordinations tell machines, or want to know of them.
pub(super) fn words(plans: &[Arc<Plan>]) -> Words<'_> {
    let mut words = Words::new();
    for script in plans.iter().flat_map(|plan| scripts(plan)) {
        for flag in &script.flags {
            let event = flag.instruction.iter().map(|own| own.event.as_str());
            for word in event.chain([flag.on_output.as_str()]) {
                let number = words.len() as u16;
                words.entry(word).or_insert(number);
            }
        }
    }
    words
}

fn scripts(plan: &Plan) -> impl Iterator<Item = &Script> {
    let yields = plan.preempt.iter().flat_map(|own| &own.yields);
    let own = plan.roles.iter().map(|role| &role.script);
    own.chain(yields.map(|own| &own.script))
}

/// What coordinations can do with a robot and want to know of it.
pub(super) fn bound<'a>(plans: &'a [Arc<Plan>], words: &Words<'a>, robot: usize) -> Bound<'a> {
    let mut bound = Bound::default();
    for plan in plans
        .iter()
        .filter(|plan| plan.controls() && is_looked_at(plan))
    {
        for (role, own) in plan.roles.iter().enumerate() {
            let casts = || plan.situations.iter().map(move |own| &own.casts[role]);
            if !casts().any(|cast| cast.names(robot)) {
                continue;
            }
            let yields = plan.preempt.as_ref().map(|own| &own.yields[role]);
            let scripts = yields.iter().map(|own| &own.script).chain([&own.script]);
            for flag in scripts.flat_map(|script| &script.flags) {
                let note = |into: &mut Words<'a>, word: &'a str| {
                    if let Some(&number) = words.get(word).filter(|_| !word.is_empty()) {
                        into.insert(word, number);
                    }
                };
                if let Some(instruction) = &flag.instruction {
                    note(&mut bound.events, &instruction.event);
                }
                note(&mut bound.outputs, &flag.on_output);
            }
            let states = casts().map(|cast| &cast.states[..]);
            let groups = states.chain(yields.iter().map(|own| &own.states[..]));
            bound
                .groups
                .extend(groups.filter(|group| !group.is_empty()));
        }
    }
    bound
}

/// Its robots are all let into areas, or all give their discrete control.
pub(crate) fn is_looked_at(plan: &Plan) -> bool {
    !plan.controls() || { plan.roles.iter() }.all(|role| matches!(role.kind, Kind::Control))
}
