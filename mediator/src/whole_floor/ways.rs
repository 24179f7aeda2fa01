//! Which placements lead where, and the way to one in words.

use super::floor::Floor;
use super::graph::{Edge, Graph, Step};
use super::state::Areas;

/// Placements from which a robot that has somewhere to go never gets there, over edges of which `counts` holds.
pub(super) fn stuck(
    floor: &Floor,
    graph: &Graph,
    robot: usize,
    counts: impl Fn(&Edge) -> bool,
) -> Vec<bool> {
    let mut moves = vec![false; graph.states.len()];
    for edge in &graph.edges {
        if edge.step == Step::Moves(robot as u16) {
            moves[edge.from as usize] = true;
        }
    }
    let goes_on = graph.can_reach(|place| moves[place], counts);
    { goes_on.into_iter().zip(&graph.states) }
        .map(|(goes_on, state)| !goes_on && floor.goes_on(state, robot))
        .collect()
}

/// The shortest way to a placement, step by step.
pub(super) fn way_to(floor: &Floor, graph: &Graph, place: usize) -> Vec<String> {
    { graph.way_to(place).into_iter() }
        .map(|(step, after)| floor.describe(step, after))
        .collect()
}

/// Areas as the site file calls them.
pub(super) fn names(floor: &Floor, areas: &Areas) -> Vec<String> {
    { areas.iter() }
        .map(|&area| floor.area_names[usize::from(area)].clone())
        .collect()
}
