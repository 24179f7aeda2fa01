//! All placements that can be reached.

use std::rc::Rc;

use hashbrown::HashMap;

use super::control_net::ControlNet;
use super::floor::Floor;
use super::gate_net::GateNet;
use super::graph::{Edge, Graph};
use super::state::{RobotState, State};
use super::verdict::{MOST, MOST_PLACES};

/// What can be reached, as far as it was looked at.
pub(super) struct Explored {
    pub(super) graph: Graph,
    /// What can happen in the placements before this one is known; the others were only found.
    pub(super) known: usize,
    /// All placements that so many steps lead to were found.
    pub(super) steps: usize,
}

impl Explored {
    /// There is nothing else.
    pub(super) fn is_whole(&self) -> bool {
        self.known == self.graph.states.len()
    }
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
                        let known = from as usize;
                        return Explored {
                            graph,
                            known,
                            steps,
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
        Explored {
            known: graph.states.len(),
            graph,
            steps,
        }
    }
}
