//! Whether one robot can wait for ever while others go on.
//!
//! It can if they can go round and round without it, though all are fair: whatever is possible again and again happens at some
//! time (strong fairness), but for which way a robot goes, for grants that go to a larger priority first, and for transitions that
//! are never the choice of their net's executor: it goes around, so that an unlucky rhythm can miss one for ever. What is left of the
//! graph after taking out, again and again, where that would not be so, are the rounds in which a robot starves (Lichtenstein and
//! Pnueli 1985).

use std::collections::HashSet;

use super::floor::Floor;
use super::graph::{Edge, Graph, Step};

/// The edges that leave each placement, as far as they can be taken again and again.
pub(super) struct Leaving<'a> {
    edges: Vec<&'a Edge>,
    begins: Vec<usize>,
}

impl<'a> Leaving<'a> {
    pub(super) fn of(graph: &'a Graph) -> Self {
        // Nothing takes too long again and again, and nets choose in their order.
        let counts = |edge: &&Edge| !edge.step.is_late() && !edge.out_of_turn;
        let edges = graph.edges.iter().filter(counts);
        let mut edges: Vec<&Edge> = edges.collect();
        edges.sort_by_key(|edge| edge.from);
        let begins = (0..=graph.states.len())
            .map(|place| edges.partition_point(|edge| (edge.from as usize) < place))
            .collect();
        Self { edges, begins }
    }

    fn of_place(&self, place: usize) -> &[&'a Edge] {
        &self.edges[self.begins[place]..self.begins[place + 1]]
    }
}

/// The nearest placement of a round in which `robot` starves, if there is one.
pub(super) fn starves(
    floor: &Floor,
    graph: &Graph,
    leaving: &Leaving<'_>,
    robot: usize,
) -> Option<usize> {
    // A grant is not yet a way: it may have to give it back, and be granted it again, for ever.
    let goes_on = |edge: &Edge| {
        let moves = matches!(edge.step, Step::Moves(own) if usize::from(own) == robot);
        moves && !edge.outranked
    };
    // Where it could go on it would, by fairness; where it has nowhere to go it misses nothing.
    let waits = (0..graph.states.len()).filter(|&place| {
        let goes_on = leaving.of_place(place).iter().any(|edge| goes_on(edge));
        floor.goes_on(&graph.states[place], robot) && !goes_on
    });
    let mut search = Search::new(graph.states.len());
    let mut open: Vec<Vec<usize>> = vec![waits.collect()];
    let mut nearest: Option<usize> = None;
    while let Some(places) = open.pop() {
        let allowed: HashSet<usize> = places.iter().copied().collect();
        for round in search.rounds(leaving, &places, &allowed) {
            let inside: HashSet<usize> = round.iter().copied().collect();
            let edges = || round.iter().flat_map(|&place| leaving.of_place(place));
            let taken: HashSet<Kind> = edges()
                .filter(|edge| inside.contains(&(edge.to as usize)))
                .map(|edge| kind(edge.step))
                .collect();
            let missed = { edges().filter(|edge| is_fair(edge)) }
                .map(|edge| kind(edge.step))
                .find(|kind| !is_served(&taken, *kind));
            match missed {
                Some(missed) => {
                    let is_possible = |place: usize| {
                        let mut edges = leaving.of_place(place).iter();
                        edges.any(|edge| is_fair(edge) && kind(edge.step) == missed)
                    };
                    open.push(
                        round
                            .into_iter()
                            .filter(|&place| !is_possible(place))
                            .collect(),
                    );
                }
                None if taken.iter().any(|kind| matches!(kind, Kind::Moves(_))) => {
                    let first = round.iter().copied().min();
                    nearest = nearest.into_iter().chain(first).min();
                }
                None => {}
            }
        }
    }
    nearest
}

/// What is fair: a robot drives on whichever way, all else happens as such.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
enum Kind {
    Moves(u16),
    /// It goes on where it is.
    Turns(u16),
    Other(Step),
}

fn kind(step: Step) -> Kind {
    match step {
        Step::Moves(robot) => Kind::Moves(robot),
        Step::Turns(robot) => Kind::Turns(robot),
        step => Kind::Other(step),
    }
}

/// It is among what happens; whatever makes a robot go on where it is sends it on at last.
fn is_served(taken: &HashSet<Kind>, kind: Kind) -> bool {
    match kind {
        Kind::Turns(robot) => taken.contains(&kind) && taken.contains(&Kind::Moves(robot)),
        kind => taken.contains(&kind),
    }
}

/// It happens at some time if it is possible again and again.
fn is_fair(edge: &Edge) -> bool {
    !edge.outranked && !matches!(edge.step, Step::Heads(..))
}

/// What a search for rounds remembers of each placement.
struct Search {
    index: Vec<usize>,
    low: Vec<usize>,
    on_stack: Vec<bool>,
}

const NONE: usize = usize::MAX;

impl Search {
    fn new(count: usize) -> Self {
        Self {
            index: vec![NONE; count],
            low: vec![NONE; count],
            on_stack: vec![false; count],
        }
    }

    /// Strongly connected components with more than one placement, or an edge to itself (Tarjan 1972, without recursion).
    fn rounds(
        &mut self,
        leaving: &Leaving<'_>,
        places: &[usize],
        allowed: &HashSet<usize>,
    ) -> Vec<Vec<usize>> {
        let Self {
            index,
            low,
            on_stack,
        } = self;
        // Other searches have been here.
        places.iter().for_each(|&place| index[place] = NONE);
        let (mut stack, mut found, mut next) = (Vec::new(), Vec::new(), 0);
        for &root in places {
            if index[root] != NONE {
                continue;
            }
            let mut calls = vec![(root, 0)];
            while let Some((place, edge)) = calls.pop() {
                if edge == 0 {
                    (index[place], low[place]) = (next, next);
                    next += 1;
                    stack.push(place);
                    on_stack[place] = true;
                }
                let edges = leaving.of_place(place);
                if let Some(following) = edges.get(edge) {
                    calls.push((place, edge + 1));
                    let to = following.to as usize;
                    if !allowed.contains(&to) {
                        continue;
                    }
                    if index[to] == NONE {
                        calls.push((to, 0));
                    } else if on_stack[to] {
                        low[place] = low[place].min(index[to]);
                    }
                    continue;
                }
                if let Some(&(caller, _)) = calls.last() {
                    low[caller] = low[caller].min(low[place]);
                }
                if low[place] == index[place] {
                    let begin = { stack.iter() }.rposition(|&own| own == place);
                    let component = stack.split_off(begin.unwrap_or_default());
                    for &own in &component {
                        on_stack[own] = false;
                    }
                    let to_itself = || edges.iter().any(|edge| edge.to as usize == place);
                    if component.len() > 1 || to_itself() {
                        found.push(component);
                    }
                }
            }
        }
        found
    }
}
