//! Every regular state of a robot's machine, and back to where it began.
//!
//! The machine says which states were scheduled; that they were driven is judged by the areas that the robot was in.

use std::collections::BTreeSet;

use config::SiteConfig;
use description::site::{ControllerConfig, FsmConfig, MonitorKind};

/// One robot's way through its machine.
#[derive(Clone, Debug)]
pub(super) struct States {
    start: String,
    /// Each regular state with its areas; the robot must have been in one of them.
    regular: Vec<(String, Vec<String>)>,
}

impl States {
    /// From this state on.
    pub(super) fn new(site: &SiteConfig, fsm: &FsmConfig, start: &str) -> Self {
        let areas = |state: &String| -> Vec<String> {
            let state = fsm.state(state).into_iter();
            state
                .flat_map(|state| state.areas())
                .map(str::to_owned)
                .collect()
        };
        Self {
            start: start.to_owned(),
            regular: { regular_states(site, fsm, start).into_iter() }
                .map(|state| (state.clone(), areas(&state)))
                .collect(),
        }
    }

    /// Whether a robot that was in these states, in order, and in these areas is back from all of them.
    pub(super) fn is_done(&self, states: &[String], areas: &BTreeSet<String>) -> bool {
        let back = states.len() > 1 && states.last() == Some(&self.start);
        back && { self.regular.iter() }.all(|(state, within)| {
            states.contains(state) && within.iter().any(|area| areas.contains(area))
        })
    }

    /// What is still to be done, in words.
    pub(super) fn missing(&self, states: &[String]) -> String {
        let missing: Vec<&str> = { self.regular.iter() }
            .map(|(state, _)| state)
            .filter(|state| !states.contains(state))
            .map(String::as_str)
            .collect();
        format!(
            "{} states were not reached ({}); it ended in {}",
            missing.len(),
            missing.join(", "),
            states.last().map_or("none", String::as_str)
        )
    }
}

/// States that a robot passes through when all goes well: all that can be reached without straying and without an
/// operator's reset.
fn regular_states(site: &SiteConfig, fsm: &FsmConfig, start: &str) -> Vec<String> {
    let strays = |event: &str| {
        event == "reset"
            || site
                .monitor(event)
                .is_some_and(|monitor| matches!(monitor.kind, MonitorKind::Deviation { .. }))
    };
    let mut reached = vec![start.to_owned()];
    let mut next = 0;
    while let Some(state) = reached.get(next).cloned() {
        next += 1;
        let outgoing = fsm.transitions.iter().filter(|one| one.from == state);
        for transition in outgoing.filter(|one| !strays(&one.on)) {
            if !reached.contains(&transition.to) && !is_halt(site, fsm, &transition.to) {
                reached.push(transition.to.clone());
            }
        }
    }
    reached
}

/// A state that only an operator's reset ends.
fn is_halt(site: &SiteConfig, fsm: &FsmConfig, state: &str) -> bool {
    let stops = fsm
        .state(state)
        .and_then(|state| site.skill(&state.skill))
        .is_some_and(|skill| skill.controller == ControllerConfig::Stop);
    let mut outgoing = fsm.transitions.iter().filter(|one| one.from == state);
    stops && outgoing.all(|one| one.on == "reset")
}
