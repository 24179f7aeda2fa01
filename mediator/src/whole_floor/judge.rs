//! What the graph says.

use super::deaths;
use super::explore::Explored;
use super::floor::Floor;
use super::graph::Graph;
use super::starvation::{Leaving, starves};
use super::state::{Phase, State};
use super::verdict::{Findings, Still, Verdict, Waits};
use super::ways::{names, stuck, way_to};

pub(super) fn judge(floor: &Floor, explored: &Explored) -> Findings {
    let graph = &explored.graph;
    if explored.is_whole() {
        let stuck: Vec<Vec<bool>> = (0..floor.routes.len())
            .map(|robot| stuck(floor, graph, robot, |_| true))
            .collect();
        Findings {
            verdict: of_whole(floor, graph, &stuck),
            looked: graph.states.len(),
            is_whole: true,
            deaths: deaths::of_whole(floor, graph, &stuck),
            stills: stills(floor, graph),
        }
    } else {
        let waits = wait_anyway(floor, explored);
        Findings {
            verdict: of_part(floor, explored, &waits),
            looked: graph.states.len(),
            is_whole: false,
            deaths: deaths::of_part(floor, graph, &waits),
            stills: Vec::new(),
        }
    }
}

/// `stuck`: by robot, the placements from which it never gets to where it goes.
fn of_whole(floor: &Floor, graph: &Graph, stuck: &[Vec<bool>]) -> Verdict {
    let robots = 0..floor.routes.len();
    let first = (0..graph.states.len()).find(|&place| stuck.iter().any(|own| own[place]));
    if let Some(place) = first {
        let waits: Vec<usize> = robots.filter(|&robot| stuck[robot][place]).collect();
        return dead(floor, graph, place, &waits);
    }
    let leaving = Leaving::of(graph);
    let starving =
        robots.filter_map(|robot| Some((starves(floor, graph, &leaving, robot)?, robot)));
    match starving.min() {
        Some((place, robot)) => Verdict::Starves {
            steps: way_to(floor, graph, place),
            waits: waits_at(floor, &graph.states[place], robot),
        },
        None => Verdict::Never,
    }
}

fn of_part(floor: &Floor, explored: &Explored, waits: &[Vec<usize>]) -> Verdict {
    match waits.iter().position(|waits| !waits.is_empty()) {
        Some(place) => dead(floor, &explored.graph, place, &waits[place]),
        None => Verdict::Unknown {
            steps: explored.steps,
        },
    }
}

/// By placement: robots that wait for each other by the order of areas, which is so whatever there is besides; where nothing can happen any
/// more, all that have somewhere to go.
fn wait_anyway(floor: &Floor, explored: &Explored) -> Vec<Vec<usize>> {
    let states = &explored.graph.states;
    // Of those that were only found, nobody knows.
    let mut leads_on = vec![true; states.len()];
    leads_on[..explored.known].fill(false);
    for edge in &explored.graph.edges {
        leads_on[edge.from as usize] = true;
    }
    let waits = states.iter().zip(leads_on).map(|(state, leads_on)| {
        if leads_on {
            floor.occupied(state).who_waits_for_each_other()
        } else {
            let robots = 0..floor.routes.len();
            robots.filter(|&own| floor.goes_on(state, own)).collect()
        }
    });
    waits.collect()
}

/// These robots wait for ever there.
fn dead(floor: &Floor, graph: &Graph, place: usize, waits: &[usize]) -> Verdict {
    let state = &graph.states[place];
    Verdict::May {
        steps: way_to(floor, graph, place),
        waits: { waits.iter() }
            .map(|&robot| waits_at(floor, state, robot))
            .collect(),
    }
}

/// Coordinations that come to an end only when somebody has waited for too long.
fn stills(floor: &Floor, graph: &Graph) -> Vec<Still> {
    let stills = floor
        .controls
        .iter()
        .enumerate()
        .filter_map(|(number, net)| {
            let is_idle = |place: usize| graph.states[place].controls[number].phase == Phase::Idle;
            let ends = graph.can_reach(is_idle, |edge| !edge.step.is_late());
            let ends_late = graph.can_reach(is_idle, |_| true);
            let runs = |place: &usize| {
                let phase = &graph.states[*place].controls[number].phase;
                matches!(phase, Phase::Running { .. })
            };
            let first = (0..graph.states.len())
                .find(|place| !ends[*place] && ends_late[*place] && runs(place))?;
            Some(Still {
                coordination: net.id.clone(),
                steps: way_to(floor, graph, first),
            })
        });
    stills.collect()
}

fn waits_at(floor: &Floor, state: &State, robot: usize) -> Waits {
    Waits {
        robot: floor.routes[robot].robot.clone(),
        has: names(floor, &floor.has(state, robot)),
        let_into: names(floor, &floor.let_into(state, robot)),
        needs: names(floor, &floor.needs(state, robot)),
    }
}
