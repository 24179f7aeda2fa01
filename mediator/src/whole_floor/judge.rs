//! What the graph says.

use std::collections::BTreeSet;

use super::explore::Floor;
use super::graph::{Graph, Step};
use super::starvation::{Leaving, starves};
use super::state::{Areas, State};
use super::verdict::{Death, Verdict, Waits};

pub(super) fn judge(floor: &Floor, graph: &Graph) -> Verdict {
    let robots = 0..floor.routes.len();
    let stuck: Vec<Vec<bool>> = { robots.clone() }
        .map(|robot| stuck(floor, graph, robot))
        .collect();
    let first = (0..graph.states.len()).find(|&place| stuck.iter().any(|own| own[place]));
    if let Some(place) = first {
        let state = &graph.states[place];
        let waits = robots.filter(|&robot| stuck[robot][place]);
        return Verdict::May {
            steps: way_to(floor, graph, place),
            waits: waits.map(|robot| waits_at(floor, state, robot)).collect(),
        };
    }
    let leaving = Leaving::of(graph);
    let starving = { robots.clone() }
        .filter_map(|robot| Some((starves(floor, graph, &leaving, robot)?, robot)));
    if let Some((place, robot)) = starving.min() {
        return Verdict::Starves {
            steps: way_to(floor, graph, place),
            waits: waits_at(floor, &graph.states[place], robot),
        };
    }
    Verdict::Never {
        looked: graph.states.len(),
        deaths: robots
            .flat_map(|robot| deaths(floor, graph, robot))
            .collect(),
    }
}

fn way_to(floor: &Floor, graph: &Graph, place: usize) -> Vec<String> {
    { graph.way_to(place).into_iter() }
        .map(|(step, after)| floor.describe(step, after))
        .collect()
}

fn waits_at(floor: &Floor, state: &State, robot: usize) -> Waits {
    Waits {
        robot: floor.routes[robot].robot.clone(),
        has: names(floor, &floor.has(state, robot)),
        let_into: names(floor, &floor.let_into(state, robot)),
        needs: names(floor, &floor.needs(state, robot)),
    }
}

/// Placements from which a robot that has somewhere to go never gets there.
fn stuck(floor: &Floor, graph: &Graph, robot: usize) -> Vec<bool> {
    let mut moves = vec![false; graph.states.len()];
    for edge in &graph.edges {
        if edge.step == Step::Moves(robot as u16) {
            moves[edge.from as usize] = true;
        }
    }
    let goes_on = graph.can_reach(|place| moves[place], |_| true);
    { goes_on.into_iter().zip(&graph.states) }
        .map(|(goes_on, state)| {
            let node = usize::from(state.robots[robot].node);
            !goes_on && !floor.routes[robot].next[node].is_empty()
        })
        .collect()
}

/// Nets that cannot come to an end any more when a robot dies, and what it has then.
fn deaths<'a>(
    floor: &'a Floor,
    graph: &'a Graph,
    robot: usize,
) -> impl Iterator<Item = Death> + 'a {
    { floor.nets.iter().enumerate() }.filter_map(move |(number, net)| {
        let is_end = |place: usize| {
            let own = &graph.states[place].nets[number];
            own.begun && net.is_at_an_end(own)
        };
        let ends = graph.can_reach(is_end, |edge| edge.step.robot() != Some(robot));
        let never = { ends.iter().enumerate() }.filter(|(_, ends)| !**ends);
        let stands_in: BTreeSet<u16> = never
            .flat_map(|(place, _)| floor.stands_in(&graph.states[place], robot))
            .copied()
            .collect();
        (!stands_in.is_empty()).then(|| Death {
            robot: floor.routes[robot].robot.clone(),
            coordination: net.id.clone(),
            stands_in: names(floor, &stands_in.into_iter().collect()),
        })
    })
}

fn names(floor: &Floor, areas: &Areas) -> Vec<String> {
    { areas.iter() }
        .map(|&area| floor.area_names[usize::from(area)].clone())
        .collect()
}
