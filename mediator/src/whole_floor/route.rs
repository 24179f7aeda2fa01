//! A robot's machine as far as areas go.

use std::collections::{BTreeMap, BTreeSet};

use config::SiteConfig;
use description::site::{FsmConfig, FsmTransition};

use super::state::{Areas, join};

/// A way from one node to the next.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Way {
    pub(super) to: u16,
    /// What the machine puts out on it, as far as a coordination wants to know.
    pub(super) outputs: Vec<u16>,
}

/// A robot's machine as far as areas and orders go: states with the same areas, the same ways on and the same use for orders are one
/// node.
pub(super) struct Route {
    pub(super) robot: String,
    /// Who goes first where several ask.
    pub(super) priority: u32,
    /// It goes before all others once enough of them went before it.
    pub(super) ages: bool,
    pub(super) start: u16,
    /// By node.
    pub(super) areas: Vec<Areas>,
    /// By node: those that can follow by themselves. Which one does, is none of the mediator's choice.
    pub(super) ways: Vec<Vec<Way>>,
    /// By node: those that follow on an order of the mediator.
    pub(super) orders: Vec<Vec<(u16, Way)>>,
    /// By node: some way leads on to other areas.
    pub(super) leads_on: Vec<bool>,
    /// The machine's states by name, each with its node.
    pub(super) states: Vec<(String, u16)>,
}

/// What coordinations can do with a robot and want to know of it.
#[derive(Default)]
pub(super) struct Bound<'a> {
    /// Events that only they post, and outputs that they wait for: by number.
    pub(super) events: BTreeMap<&'a str, u16>,
    pub(super) outputs: BTreeMap<&'a str, u16>,
    /// Lists of states between which they make a difference.
    pub(super) groups: Vec<&'a [String]>,
}

/// What makes two states of a machine differ for others, besides the ways on.
#[derive(Clone, Debug, PartialEq, Eq)]
struct Label {
    areas: Areas,
    /// Event, state that follows, outputs.
    orders: Vec<(u16, usize, Vec<u16>)>,
    groups: Vec<bool>,
}

impl Route {
    pub(super) fn of(
        robot: &str,
        site: &SiteConfig,
        fsm: &FsmConfig,
        start: &str,
        bound: &Bound<'_>,
    ) -> Option<Self> {
        let labels = labels(site, fsm, bound);
        let ways = ways(fsm, &labels, bound);
        let nodes = nodes(&labels, &ways);
        let count = nodes.iter().max().map_or(0, |&last| usize::from(last) + 1);
        let mut own = Self {
            start: nodes[{ fsm.states.iter() }.position(|state| state.name == start)?],
            ..Self::of_nodes(robot, vec![Areas::new(); count])
        };
        for (state, &node) in nodes.iter().enumerate() {
            let node = usize::from(node);
            own.areas[node].clone_from(&labels[state].areas);
            for (to, outputs) in &ways[state] {
                let to = nodes[*to];
                let outputs = outputs.clone();
                own.ways[node].push(Way { to, outputs });
            }
            for (event, to, outputs) in &labels[state].orders {
                let to = nodes[*to];
                let outputs = outputs.clone();
                own.orders[node].push((*event, Way { to, outputs }));
            }
        }
        for ways in &mut own.ways {
            ways.sort_unstable();
            ways.dedup();
        }
        for orders in &mut own.orders {
            orders.sort_unstable();
            orders.dedup();
        }
        let names = fsm.states.iter().map(|state| state.name.clone());
        own.states = names.zip(nodes).collect();
        own.look_where_it_leads();
        Some(own)
    }

    /// Nodes from which nothing leads on yet.
    pub(super) fn of_nodes(robot: &str, areas: Vec<Areas>) -> Self {
        let count = areas.len();
        Self {
            robot: robot.to_owned(),
            priority: 0,
            ages: false,
            start: 0,
            areas,
            ways: vec![Vec::new(); count],
            orders: vec![Vec::new(); count],
            leads_on: vec![false; count],
            states: Vec::new(),
        }
    }

    /// Fills in which nodes lead on.
    pub(super) fn look_where_it_leads(&mut self) {
        let next = |node: usize| {
            let orders = self.orders[node].iter().map(|(_, way)| way.to);
            self.ways[node].iter().map(|way| way.to).chain(orders)
        };
        let mut leads_on = vec![false; self.areas.len()];
        loop {
            let more: Vec<usize> = (0..leads_on.len())
                .filter(|&node| !leads_on[node])
                .filter(|&node| {
                    next(node)
                        .map(usize::from)
                        .any(|to| leads_on[to] || self.areas[to] != self.areas[node])
                })
                .collect();
            if more.is_empty() {
                break;
            }
            more.into_iter().for_each(|node| leads_on[node] = true);
        }
        self.leads_on = leads_on;
    }

    /// The node is that of one of these states.
    pub(super) fn is_one_of(&self, node: u16, states: &[String]) -> bool {
        let mut own = self.states.iter().filter(|(_, own)| *own == node);
        own.any(|(name, _)| states.contains(name))
    }
}

fn number(fsm: &FsmConfig, state: &str) -> Option<usize> {
    fsm.states.iter().position(|own| own.name == state)
}

fn outputs_of(transition: &FsmTransition, bound: &Bound<'_>) -> Vec<u16> {
    let known = |output: &String| bound.outputs.get(output.as_str()).copied();
    transition.outputs.iter().filter_map(known).collect()
}

fn labels(site: &SiteConfig, fsm: &FsmConfig, bound: &Bound<'_>) -> Vec<Label> {
    let labels = fsm.states.iter().map(|state| {
        let mut areas = Areas::new();
        let place = |id| site.areas.iter().position(|area| area.id == id);
        join(
            &mut areas,
            { state.areas() }.filter_map(place).map(|area| area as u16),
        );
        let own = fsm.transitions.iter().filter(|own| own.from == state.name);
        let mut orders: Vec<(u16, usize, Vec<u16>)> = own
            .filter_map(|own| {
                let event = *bound.events.get(own.on.as_str())?;
                Some((event, number(fsm, &own.to)?, outputs_of(own, bound)))
            })
            .collect();
        orders.sort_unstable();
        let groups = bound.groups.iter();
        Label {
            areas,
            orders,
            groups: groups.map(|group| group.contains(&state.name)).collect(),
        }
    });
    labels.collect()
}

/// From each state, those with other labels that it comes to next by itself, through however many with its own, and what is put out on
/// the way.
fn ways(fsm: &FsmConfig, labels: &[Label], bound: &Bound<'_>) -> Vec<BTreeSet<(usize, Vec<u16>)>> {
    let mut next: Vec<Vec<(usize, Vec<u16>)>> = vec![Vec::new(); labels.len()];
    for own in &fsm.transitions {
        if let (Some(from), Some(to)) = (number(fsm, &own.from), number(fsm, &own.to))
            && !bound.events.contains_key(own.on.as_str())
        {
            next[from].push((to, outputs_of(own, bound)));
        }
    }
    (0..labels.len())
        .map(|state| {
            let (mut seen, mut open) = (BTreeSet::from([state]), vec![state]);
            let mut found = BTreeSet::new();
            while let Some(from) = open.pop() {
                for (to, outputs) in &next[from] {
                    if labels[*to] != labels[state] || !outputs.is_empty() {
                        found.insert((*to, outputs.clone()));
                    } else if seen.insert(*to) {
                        open.push(*to);
                    }
                }
            }
            found
        })
        .collect()
}

/// The node of each state: the coarsest ones of which all states have the same areas, the same nodes next, and the same use for orders.
fn nodes(labels: &[Label], ways: &[BTreeSet<(usize, Vec<u16>)>]) -> Vec<u16> {
    let mut nodes = vec![0_u16; labels.len()];
    let mut count = 1;
    loop {
        let mut numbers = BTreeMap::new();
        let finer: Vec<u16> = (0..labels.len())
            .map(|state| {
                let own = &labels[state];
                let next: BTreeSet<(u16, &[u16])> = { ways[state].iter() }
                    .map(|(to, outputs)| (nodes[*to], &outputs[..]))
                    .collect();
                let orders: Vec<(u16, u16, &[u16])> = { own.orders.iter() }
                    .map(|(event, to, outputs)| (*event, nodes[*to], &outputs[..]))
                    .collect();
                let next_number = numbers.len() as u16;
                *numbers
                    .entry((nodes[state], &own.areas, &own.groups, next, orders))
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
