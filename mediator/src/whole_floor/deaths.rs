//! Who waits for a robot that dies.

use std::collections::BTreeSet;

use super::floor::Floor;
use super::gate_net::GateNet;
use super::graph::{Edge, Graph, Step};
use super::state::{Phase, State};
use super::verdict::Death;
use super::ways::{names, stuck, way_to};

/// Exactly, by what can be reached. `stuck`: by robot, the placements from which it never goes on although all live.
pub(super) fn of_whole(floor: &Floor, graph: &Graph, stuck: &[Vec<bool>]) -> Vec<Death> {
    let ends = Ends::of(floor, graph);
    let robots = 0..floor.routes.len();
    robots
        .filter_map(|robot| of_robot(floor, graph, robot, stuck, &ends))
        .collect()
}

/// A coordination that has an end: its name, and where it is there.
struct End<'a> {
    id: &'a str,
    is_there: Vec<bool>,
    /// From there it never is, although all live.
    never: Vec<bool>,
}

struct Ends<'a>(Vec<End<'a>>);

impl<'a> Ends<'a> {
    fn of(floor: &'a Floor, graph: &Graph) -> Self {
        let end = |id: &'a str, is_there: &dyn Fn(&State) -> bool| {
            let is_there: Vec<bool> = graph.states.iter().map(|state| is_there(state)).collect();
            let reached = graph.can_reach(|place| is_there[place], |_| true);
            End {
                id,
                is_there,
                never: reached.into_iter().map(|reached| !reached).collect(),
            }
        };
        // A net that declares no end, or that never begins for want of robots, comes to none whoever lives.
        let can_end = |(number, net): &(usize, &GateNet)| {
            net.tokens.has_ends() && graph.states[0].gates[*number].may_begin()
        };
        let gates = floor.gates.iter().enumerate().filter(can_end);
        let gates = gates.map(|(number, net)| {
            end(&net.id, &|state| {
                let own = &state.gates[number];
                own.begun && net.tokens.are_at_an_end(&own.marks)
            })
        });
        let controls = floor.controls.iter().enumerate().map(|(number, net)| {
            end(&net.id, &|state| {
                state.controls[number].phase == Phase::Idle
            })
        });
        Self(gates.chain(controls).collect())
    }
}

/// Who and what can wait for this robot once it is dead, and where it stands then.
fn of_robot(
    floor: &Floor,
    graph: &Graph,
    robot: usize,
    stuck_anyway: &[Vec<bool>],
    ends: &Ends<'_>,
) -> Option<Death> {
    let happens = |edge: &Edge| happens_without(graph, edge, robot);
    // It stays where it is, whatever it is told: a way of others that needs more is none.
    let stays = |edge: &Edge| {
        let [before, after] = [edge.from, edge.to].map(|place| &*graph.states[place as usize]);
        floor.stands_in(before, robot) == floor.stands_in(after, robot)
    };
    let mut waits = vec![false; graph.states.len()];
    // Whether there is any place where this is so for its death only.
    let mut take = |places: Vec<bool>, anyway: &[bool]| {
        let mut any = false;
        for ((all, own), anyway) in waits.iter_mut().zip(places).zip(anyway) {
            let by_death = own && !anyway;
            *all |= by_death;
            any |= by_death;
        }
        any
    };
    let others = (0..floor.routes.len()).filter(|&other| other != robot);
    let robots: Vec<String> = others
        .filter(|&other| {
            let stuck = stuck(floor, graph, other, |edge| happens(edge) && stays(edge));
            take(stuck, &stuck_anyway[other])
        })
        .map(|other| floor.routes[other].robot.clone())
        .collect();
    let coordinations: Vec<String> = { ends.0.iter() }
        .filter(|end| {
            let reached = graph.can_reach(|place| end.is_there[place], happens);
            let never = reached.into_iter().map(|reached| !reached).collect();
            take(never, &end.never)
        })
        .map(|end| end.id.to_owned())
        .collect();
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

/// By the order of areas alone, in the placements that were found: what a dead robot has stays taken, and who needs it stays where it is
/// with what it has. `anyway`: by placement, who waits although all live.
pub(super) fn of_part(floor: &Floor, graph: &Graph, anyway: &[Vec<usize>]) -> Vec<Death> {
    let count = floor.routes.len();
    let mut robots: Vec<BTreeSet<usize>> = vec![BTreeSet::new(); count];
    let mut stands_in: Vec<BTreeSet<u16>> = vec![BTreeSet::new(); count];
    let mut first: Vec<Option<usize>> = vec![None; count];
    for (place, (state, anyway)) in graph.states.iter().zip(anyway).enumerate() {
        let occupied = floor.occupied(state);
        for dead in 0..count {
            let mut held_up = occupied.who_waits_for(dead);
            held_up.retain(|robot| !anyway.contains(robot));
            if !held_up.is_empty() {
                first[dead].get_or_insert(place);
                robots[dead].extend(held_up);
                stands_in[dead].extend(floor.stands_in(state, dead));
            }
        }
    }
    (0..count)
        .filter_map(|dead| {
            Some(Death {
                steps: way_to(floor, graph, first[dead]?),
                robot: floor.routes[dead].robot.clone(),
                stands_in: names(floor, &stands_in[dead].iter().copied().collect()),
                robots: { robots[dead].iter() }
                    .map(|&robot| floor.routes[robot].robot.clone())
                    .collect(),
                coordinations: Vec::new(),
            })
        })
        .collect()
}
