//! What can happen next, and all placements that can be reached.

use std::collections::HashMap;
use std::rc::Rc;

use super::floor::Floor;
use super::gate_net::GateNet;
use super::graph::{Edge, Graph, Step};
use super::state::{Areas, RobotState, State, join};
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
            nets: self.nets.iter().map(GateNet::begin).collect(),
        }
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
        let most = MOST.min(MOST_PLACES / self.routes.len().max(1));
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

    /// What follows by itself.
    fn follow(&self, state: &mut State) {
        let mut nets = std::mem::take(&mut state.nets);
        for (net, own) in self.nets.iter().zip(&mut nets) {
            let robots = 0..self.routes.len();
            let is_empty =
                |area: &u16| { robots.clone() }.all(|robot| !self.has(state, robot).contains(area));
            own.begun = own.begun || own.may_begin() && net.governed.iter().all(is_empty);
            if own.begun {
                net.follow(
                    own,
                    |robot, area| self.has(state, robot).contains(&area),
                    |robot, area| self.stands_in(state, robot).contains(&area),
                    |robot, area| self.needs(state, robot).contains(&area),
                );
            }
        }
        state.nets = nets;
        for (route, own) in self.routes.iter().zip(&mut state.robots) {
            if let [only] = route.next[usize::from(own.node)][..] {
                own.to = Some(only);
            }
        }
    }

    /// Everything that can happen next.
    fn steps(&self, state: &State) -> Vec<(Step, State)> {
        // Nothing else can make a difference to that, nor it to anything else but the robot's own way.
        let open = { 0..self.routes.len() }
            .find(|&robot| state.robots[robot].to.is_none() && self.goes_on(state, robot));
        if let Some(robot) = open {
            return self.ways(state, robot);
        }
        let mut steps = Vec::new();
        for (number, net) in self.nets.iter().enumerate() {
            let own = &state.nets[number];
            if !own.begun {
                continue;
            }
            for transition in net.enabled(own) {
                let mut after = state.clone();
                net.fire(&mut after.nets[number], transition);
                let step = Step::Fires(number as u16, transition as u16);
                if net.is_free(transition) {
                    // Nothing else can make a difference to it, nor it to anything else.
                    return vec![(step, after)];
                }
                steps.push((step, after));
            }
        }
        for robot in 0..self.routes.len() {
            self.moves(state, robot, &mut steps);
            self.grants(state, robot, &mut steps);
            self.questions(state, robot, &mut steps);
        }
        steps
    }

    /// It turns out where it goes next. What decides that, such as what it sees, does not ask which way is free.
    fn ways(&self, state: &State, robot: usize) -> Vec<(Step, State)> {
        let next = &self.routes[robot].next[usize::from(state.robots[robot].node)];
        let ways = next.iter().map(|&to| {
            let mut after = state.clone();
            after.robots[robot].to = Some(to);
            (Step::Heads(robot as u16), after)
        });
        ways.collect()
    }

    /// It drives on where it has all areas for it.
    fn moves(&self, state: &State, robot: usize, steps: &mut Vec<(Step, State)>) {
        let Some(to) = state.robots[robot].to else {
            return;
        };
        let has = self.has(state, robot);
        let mut areas = self.routes[robot].areas[usize::from(to)].iter();
        if areas.all(|area| has.contains(area)) {
            let mut after = state.clone();
            after.robots[robot] = RobotState::at(to);
            steps.push((Step::Moves(robot as u16), after));
        }
    }

    /// It is granted an area.
    fn grants(&self, state: &State, robot: usize, steps: &mut Vec<(Step, State)>) {
        for area in self.needs(state, robot) {
            if self.can_be_granted(state, robot, area) {
                let mut after = state.clone();
                join(&mut after.robots[robot].ahead, [area]);
                steps.push((Step::IsGranted(robot as u16, area), after));
            }
        }
    }

    /// It asks for the areas of a passage.
    fn questions(&self, state: &State, robot: usize, steps: &mut Vec<(Step, State)>) {
        let (has, needs) = (self.has(state, robot), self.needs(state, robot));
        let is_in = |areas: &Areas, area: &usize| areas.contains(&(*area as u16));
        for (number, net) in self.nets.iter().enumerate() {
            let own = &state.nets[number];
            let wants = |other: usize, areas: &[usize]| {
                let (has, needs) = (self.has(state, other), self.needs(state, other));
                areas
                    .iter()
                    .any(|area| is_in(&has, area) || is_in(&needs, area))
            };
            let Some(role) = net.role_for(own, robot, wants).filter(|_| own.begun) else {
                continue;
            };
            if !own.roles[role].is_open() {
                continue;
            }
            let mut passages = net.roles[role].passages.iter();
            let passage = passages.position(|passage| {
                passage
                    .areas
                    .iter()
                    .all(|area| is_in(&has, area) || is_in(&needs, area))
                    && passage.areas.iter().any(|area| is_in(&needs, area))
            });
            if let Some(passage) = passage {
                let mut after = state.clone();
                net.ask(&mut after.nets[number], role, robot, passage);
                steps.push((Step::Asks(robot as u16, number as u16), after));
            }
        }
    }
}
