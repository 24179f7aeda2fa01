//! A robot's machine as far as areas go.

use config::SiteConfig;
use description::site::FsmConfig;

use super::state::{Areas, join};

/// A robot's machine as far as areas go: states of the same areas that follow on each other are one.
pub(super) struct Route {
    pub(super) robot: String,
    pub(super) start: u16,
    /// By node.
    pub(super) areas: Vec<Areas>,
    /// By node: those that can follow.
    pub(super) next: Vec<Vec<u16>>,
}

impl Route {
    pub(super) fn of(robot: &str, site: &SiteConfig, fsm: &FsmConfig, start: &str) -> Option<Self> {
        let number = |name: &str| fsm.states.iter().position(|state| state.name == name);
        let areas: Vec<Areas> = { fsm.states.iter() }
            .map(|state| {
                let mut areas = Areas::new();
                let number = |id| site.areas.iter().position(|area| area.id == id);
                join(
                    &mut areas,
                    { state.areas() }.filter_map(number).map(|area| area as u16),
                );
                areas
            })
            .collect();
        let mut next: Vec<Vec<usize>> = vec![Vec::new(); areas.len()];
        for transition in &fsm.transitions {
            if !fsm.external.contains(&transition.on)
                && let (Some(from), Some(to)) = (number(&transition.from), number(&transition.to))
            {
                next[from].push(to);
            }
        }
        let leads_on: Vec<bool> = next.iter().map(|next| !next.is_empty()).collect();
        // States of the same areas that follow on each other: the first of them stands for all.
        let mut node: Vec<usize> = (0..areas.len()).collect();
        for _ in 0..areas.len() {
            for from in 0..areas.len() {
                for &to in next[from].iter().filter(|&&to| leads_on[to]) {
                    if areas[from] == areas[to] {
                        let least = node[from].min(node[to]);
                        (node[from], node[to]) = (least, least);
                    }
                }
            }
        }
        let mut joined: Vec<Vec<u16>> = vec![Vec::new(); areas.len()];
        for from in 0..areas.len() {
            for &to in next[from].iter().filter(|&&to| leads_on[to]) {
                let (from, to) = (node[from], node[to]);
                if from != to && !joined[from].contains(&(to as u16)) {
                    joined[from].push(to as u16);
                }
            }
        }
        Some(Self {
            robot: robot.to_owned(),
            start: node[number(start)?] as u16,
            areas,
            next: joined,
        })
    }
}
