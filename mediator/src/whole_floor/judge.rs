//! What the graph says.

use std::collections::BTreeSet;

use super::floor::Floor;
use super::gate_net::GateNet;
use super::graph::{Edge, Graph, Step};
use super::starvation::{Leaving, starves};
use super::state::{Areas, Phase, State};
use super::verdict::{Death, Still, Verdict, Waits};

/// These robots wait for ever there.
pub(super) fn dead(floor: &Floor, graph: &Graph, place: usize, waits: &[usize]) -> Verdict {
    let state = &graph.states[place];
    Verdict::May {
        steps: way_to(floor, graph, place),
        waits: { waits.iter() }
            .map(|&robot| waits_at(floor, state, robot))
            .collect(),
    }
}

pub(super) fn judge(floor: &Floor, graph: &Graph) -> Verdict {
    let robots = 0..floor.routes.len();
    let stuck: Vec<Vec<bool>> = { robots.clone() }
        .map(|robot| stuck(floor, graph, robot, None))
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
            .filter_map(|robot| death(floor, graph, robot))
            .collect(),
        stills: stills(floor, graph),
    }
}

/// Coordinations that come to no end unless somebody has waited for too long.
fn stills(floor: &Floor, graph: &Graph) -> Vec<Still> {
    let stills = floor
        .controls
        .iter()
        .enumerate()
        .filter_map(|(number, net)| {
            let is_idle = |place: usize| graph.states[place].controls[number].phase == Phase::Idle;
            let ends = graph.can_reach(is_idle, |edge| !edge.step.is_late());
            let runs = |place: &usize| {
                let phase = &graph.states[*place].controls[number].phase;
                matches!(phase, Phase::Running { .. })
            };
            let first = (0..graph.states.len()).find(|place| !ends[*place] && runs(place))?;
            Some(Still {
                coordination: net.id.clone(),
                steps: way_to(floor, graph, first),
            })
        });
    stills.collect()
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

/// Placements from which a robot that has somewhere to go never gets there, when that `dead` one does nothing any more.
fn stuck(floor: &Floor, graph: &Graph, robot: usize, dead: Option<usize>) -> Vec<bool> {
    let mut moves = vec![false; graph.states.len()];
    for edge in &graph.edges {
        if edge.step == Step::Moves(robot as u16) {
            moves[edge.from as usize] = true;
        }
    }
    let lives = |edge: &Edge| dead.is_none_or(|dead| happens_without(graph, edge, dead));
    let goes_on = graph.can_reach(|place| moves[place], lives);
    { goes_on.into_iter().zip(&graph.states) }
        .map(|(goes_on, state)| !goes_on && floor.goes_on(state, robot))
        .collect()
}

/// Whether this can happen when that robot does nothing any more: nobody takes the discrete control of one that is not heard.
fn happens_without(graph: &Graph, edge: &Edge, dead: usize) -> bool {
    let takes_it = || match edge.step {
        Step::Begins(net, ..) => {
            let after = &graph.states[edge.to as usize].controls[usize::from(net)];
            after
                .roles
                .iter()
                .any(|role| usize::from(role.robot) == dead)
        }
        _ => false,
    };
    edge.step.robot() != Some(dead) && !takes_it()
}

/// Who and what can wait for a robot that dies, and where it stands then.
fn death(floor: &Floor, graph: &Graph, robot: usize) -> Option<Death> {
    let mut waits = vec![false; graph.states.len()];
    // Whether there is any; each is one of the placements.
    let mut take = |places: Vec<bool>| {
        let any = places.contains(&true);
        { waits.iter_mut().zip(places) }.for_each(|(all, own)| *all |= own);
        any
    };
    let others = (0..floor.routes.len()).filter(|&other| other != robot);
    let robots: Vec<String> = others
        .filter(|&other| take(stuck(floor, graph, other, Some(robot))))
        .map(|other| floor.routes[other].robot.clone())
        .collect();
    let mut comes_to_no_end = |is_end: &dyn Fn(&State) -> bool| {
        let is_end = |place: usize| is_end(&graph.states[place]);
        let ends = graph.can_reach(is_end, |edge| happens_without(graph, edge, robot));
        take(ends.into_iter().map(|ends| !ends).collect())
    };
    // A net that declares no end, or that never begins for want of robots, comes to none whoever lives.
    let can_end = |(number, net): &(usize, &GateNet)| {
        net.tokens.has_ends() && graph.states[0].gates[*number].may_begin()
    };
    let gates = floor.gates.iter().enumerate().filter(can_end);
    let gates = gates.filter(|(number, net)| {
        comes_to_no_end(&|state| {
            let own = &state.gates[*number];
            own.begun && net.tokens.are_at_an_end(&own.marks)
        })
    });
    let mut coordinations: Vec<String> = gates.map(|(_, net)| net.id.clone()).collect();
    let controls = floor.controls.iter().enumerate().filter(|(number, _)| {
        comes_to_no_end(&|state| state.controls[*number].phase == Phase::Idle)
    });
    coordinations.extend(controls.map(|(_, net)| net.id.clone()));
    let first = waits.iter().position(|&waits| waits)?;
    let stands_in: BTreeSet<u16> = { waits.iter().zip(&graph.states) }
        .filter(|(waits, _)| **waits)
        .flat_map(|(_, state)| floor.stands_in(state, robot))
        .copied()
        .collect();
    Some(Death {
        robot: floor.routes[robot].robot.clone(),
        stands_in: names(floor, &stands_in.into_iter().collect()),
        robots,
        coordinations,
        steps: way_to(floor, graph, first),
    })
}

fn names(floor: &Floor, areas: &Areas) -> Vec<String> {
    { areas.iter() }
        .map(|&area| floor.area_names[usize::from(area)].clone())
        .collect()
}
