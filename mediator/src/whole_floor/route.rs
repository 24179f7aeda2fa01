//! A robot's machine as far as areas go.

use std::collections::{BTreeMap, BTreeSet};

use config::SiteConfig;
use description::site::FsmConfig;

use super::state::{Areas, join};

/// A robot's machine as far as areas go: states with the same areas, and the same ways on, are one node.
pub(super) struct Route {
    pub(super) robot: String,
    /// Who goes first where several ask.
    pub(super) priority: u32,
    /// It goes before all others once enough of them went before it.
    pub(super) ages: bool,
    pub(super) start: u16,
    /// By node.
    pub(super) areas: Vec<Areas>,
    /// By node: those that can follow. Which one does, is none of the mediator's choice.
    pub(super) next: Vec<Vec<u16>>,
}

impl Route {
    pub(super) fn of(robot: &str, site: &SiteConfig, fsm: &FsmConfig, start: &str) -> Option<Self> {
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
        let ways = ways(fsm, &areas);
        let nodes = nodes(&areas, &ways);
        let count = nodes.iter().max().map_or(0, |&last| usize::from(last) + 1);
        let mut own = Self {
            robot: robot.to_owned(),
            priority: 0,
            ages: false,
            start: nodes[{ fsm.states.iter() }.position(|state| state.name == start)?],
            areas: vec![Areas::new(); count],
            next: vec![Vec::new(); count],
        };
        for (state, &node) in nodes.iter().enumerate() {
            let node = usize::from(node);
            own.areas[node].clone_from(&areas[state]);
            join(
                &mut own.next[node],
                { ways[state].iter() }.map(|&to| nodes[to]),
            );
        }
        Some(own)
    }
}

/// From each state, those with other areas that it comes to next, through however many with its own.
fn ways(fsm: &FsmConfig, areas: &[Areas]) -> Vec<BTreeSet<usize>> {
    let number = |name: &str| fsm.states.iter().position(|state| state.name == name);
    let mut next: Vec<Vec<usize>> = vec![Vec::new(); areas.len()];
    for transition in &fsm.transitions {
        if let (Some(from), Some(to)) = (number(&transition.from), number(&transition.to)) {
            next[from].push(to);
        }
    }
    (0..areas.len())
        .map(|state| {
            let (mut seen, mut open) = (BTreeSet::from([state]), vec![state]);
            let mut found = BTreeSet::new();
            while let Some(from) = open.pop() {
                for &to in &next[from] {
                    if areas[to] != areas[state] {
                        found.insert(to);
                    } else if seen.insert(to) {
                        open.push(to);
                    }
                }
            }
            found
        })
        .collect()
}

/// The node of each state: the coarsest ones of which all states have the same areas and the same nodes next.
fn nodes(areas: &[Areas], ways: &[BTreeSet<usize>]) -> Vec<u16> {
    let mut nodes = vec![0_u16; areas.len()];
    let mut count = 1;
    loop {
        let mut numbers = BTreeMap::new();
        let finer: Vec<u16> = (0..areas.len())
            .map(|state| {
                let next: BTreeSet<u16> = ways[state].iter().map(|&to| nodes[to]).collect();
                let next_number = numbers.len() as u16;
                *numbers
                    .entry((nodes[state], &areas[state], next))
                    .or_insert(next_number)
            })
            .collect();
        let found = numbers.len();
        nodes = finer;
        if found == count {
            return nodes;
        }
        count = found;
    }
}
