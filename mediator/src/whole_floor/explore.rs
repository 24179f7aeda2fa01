//! All placements that can be reached.

use std::collections::HashMap;
use std::rc::Rc;

use super::control_net::ControlNet;
use super::floor::Floor;
use super::gate_net::GateNet;
use super::graph::{Edge, Graph};
use super::state::{RobotState, State};
use super::verdict::{MOST, MOST_PLACES};

/// What was found.
pub(super) enum Explored {
    /// All that can be reached.
    Whole(Graph),
    /// There is more, and in this placement these robots wait for ever.
    Dead {
        graph: Graph,
        place: usize,
        waits: Vec<usize>,
    },
    /// There is more. Placements, and the number of steps within which they are all.
    Part { looked: usize, steps: usize },
}

impl Floor {
    fn start(&self) -> State {
        let starts = self.routes.iter().map(|route| RobotState::at(route.start));
        State {
            robots: starts.collect(),
            gates: self.gates.iter().map(GateNet::begin).collect(),
            controls: { self.controls.iter() }
                .map(|_| ControlNet::idle())
                .collect(),
        }
    }

    /// More placements are too many to look at.
    pub(super) fn most(&self) -> usize {
        MOST.min(MOST_PLACES / self.routes.len().max(1))
    }

    /// All that can be reached, as far as that is not too much.
    pub(super) fn explore(&self) -> Explored {
        let mut graph = Graph::default();
        let mut numbers: HashMap<Rc<State>, u32> = HashMap::new();
        let mut start = self.start();
        self.follow(&mut start);
        let start = Rc::new(start);
        numbers.insert(Rc::clone(&start), 0);
        graph.states.push(start);
        let most = self.most();
        // Placements before this one are all that so many steps lead to.
        let (mut steps, mut end) = (0, 1);
        let mut next = 0;
        while next < graph.states.len() {
            if next == end {
                (steps, end) = (steps + 1, graph.states.len());
            }
            let from = next as u32;
            let state = Rc::clone(&graph.states[next]);
            next += 1;
            for (step, mut after) in self.steps(&state) {
                self.follow(&mut after);
                let known = numbers.get(&after).copied();
                let to = match known {
                    Some(to) => to,
                    None if graph.states.len() == most => {
                        let part = Explored::Part {
                            looked: most,
                            steps,
                        };
                        return match self.nearest_dead(&graph, from as usize) {
                            None => part,
                            Some((place, waits)) => Explored::Dead {
                                graph,
                                place,
                                waits,
                            },
                        };
                    }
                    None => {
                        let (to, after) = (graph.states.len() as u32, Rc::new(after));
                        numbers.insert(Rc::clone(&after), to);
                        graph.states.push(after);
                        to
                    }
                };
                graph.edges.push(Edge {
                    from,
                    to,
                    step,
                    outranked: self.is_outranked(&state, step),
                    out_of_turn: self.is_out_of_turn(&state, step),
                });
            }
        }
        Explored::Whole(graph)
    }

    /// The nearest of the placements before `end` in which robots wait for ever, and who: all their edges are known.
    fn nearest_dead(&self, graph: &Graph, end: usize) -> Option<(usize, Vec<usize>)> {
        let mut leads_on = vec![false; graph.states.len()];
        for edge in &graph.edges {
            leads_on[edge.from as usize] = true;
        }
        (0..end).find_map(|place| {
            let waits = self.who_waits_for_ever(&graph.states[place], !leads_on[place]);
            (!waits.is_empty()).then_some((place, waits))
        })
    }
}
