//! What can happen next, and all placements that can be reached.

use std::collections::HashMap;
use std::rc::Rc;
use std::sync::Arc;

use config::SiteConfig;

use super::gate_net::GateNet;
use super::graph::{Edge, Graph, Step};
use super::route::Route;
use super::state::{Areas, RobotState, State, join};
use super::verdict::{MOST, MOST_PLACES};
use crate::nets::Plan;
use description::keys::quoted_list;

/// A site with its robots and its standing nets.
pub(super) struct Floor {
    pub(super) area_names: Vec<String>,
    capacities: Vec<usize>,
    pub(super) routes: Vec<Route>,
    pub(super) nets: Vec<GateNet>,
    /// By area: the net that decides about it.
    governed_by: Vec<Option<usize>>,
}

impl Floor {
    pub(super) fn new(site: &SiteConfig, plans: &[Arc<Plan>]) -> Self {
        let routes = { site.robots.iter() }.filter_map(|(id, robot)| {
            let fsm = site.fsm.get(&robot.role)?;
            let start = robot.start_state.as_ref().unwrap_or(&fsm.initial);
            Route::of(id, site, fsm, start)
        });
        let nets: Vec<GateNet> = { plans.iter() }
            .filter_map(|plan| GateNet::of(plan))
            .collect();
        let governed_by = (0..site.areas.len())
            .map(|area| { nets.iter() }.position(|net| net.governed.contains(&(area as u16))));
        Self {
            area_names: site.areas.iter().map(|area| area.id.clone()).collect(),
            capacities: { site.areas.iter() }
                .map(|area| area.capacity as usize)
                .collect(),
            routes: routes.collect(),
            governed_by: governed_by.collect(),
            nets,
        }
    }

    fn start(&self) -> State {
        let at = |route: &Route| RobotState {
            node: route.start,
            ahead: Areas::new(),
        };
        State {
            robots: self.routes.iter().map(at).collect(),
            nets: self.nets.iter().map(GateNet::begin).collect(),
        }
    }

    /// All that can be reached, or how many placements were found when that was too much.
    pub(super) fn explore(&self) -> Result<Graph, usize> {
        let mut graph = Graph::default();
        let mut numbers: HashMap<Rc<State>, u32> = HashMap::new();
        let mut start = self.start();
        self.follow(&mut start);
        let start = Rc::new(start);
        numbers.insert(Rc::clone(&start), 0);
        graph.states.push(start);
        let most = MOST.min(MOST_PLACES / self.routes.len().max(1));
        let mut next = 0;
        while next < graph.states.len() {
            let from = next as u32;
            let state = Rc::clone(&graph.states[next]);
            next += 1;
            for (step, mut after) in self.steps(&state) {
                self.follow(&mut after);
                let known = numbers.get(&after).copied();
                let to = match known {
                    Some(to) => to,
                    None if graph.states.len() == most => return Err(most),
                    None => {
                        let (to, after) = (graph.states.len() as u32, Rc::new(after));
                        numbers.insert(Rc::clone(&after), to);
                        graph.states.push(after);
                        to
                    }
                };
                graph.edges.push(Edge { from, to, step });
            }
        }
        Ok(graph)
    }

    /// A step in words, by what it leads to.
    pub(super) fn describe(&self, step: Step, after: &State) -> String {
        let robot = |robot: u16| &self.routes[usize::from(robot)].robot;
        match step {
            Step::Moves(own) => {
                let areas = self.stands_in(after, own.into()).iter();
                let names: Vec<&str> = areas
                    .map(|&area| self.area_names[usize::from(area)].as_str())
                    .collect();
                format!("{} drives into {}", robot(own), quoted_list(&names, "and"))
            }
            Step::IsGranted(own, area) => {
                let area = &self.area_names[usize::from(area)];
                format!("{} is granted `{area}`", robot(own))
            }
            Step::Asks(own, net) => {
                format!("{} asks `{}`", robot(own), self.nets[usize::from(net)].id)
            }
            Step::Fires(net, transition) => {
                let net = &self.nets[usize::from(net)];
                format!("`{}`: {}", net.id, net.transition_name(transition.into()))
            }
        }
    }

    pub(super) fn has(&self, state: &State, robot: usize) -> Areas {
        let mut has = self.stands_in(state, robot).clone();
        join(&mut has, state.robots[robot].ahead.iter().copied());
        has
    }

    /// What it lacks for going on, by all the ways that it may go.
    pub(super) fn needs(&self, state: &State, robot: usize) -> Areas {
        let (route, has) = (&self.routes[robot], self.has(state, robot));
        let next = &route.next[usize::from(state.robots[robot].node)];
        let mut needs = Areas::new();
        for &next in next {
            let areas = route.areas[usize::from(next)].iter().copied();
            join(&mut needs, areas.filter(|area| !has.contains(area)));
        }
        needs
    }

    /// A net lets the robot into the area.
    fn lets_in(&self, state: &State, robot: usize, area: u16) -> bool {
        self.governed_by[usize::from(area)].is_some_and(|net| {
            state.nets[net].begun && self.nets[net].lets_in(&state.nets[net], robot, area)
        })
    }

    /// What it lacks and a net keeps for it.
    pub(super) fn let_into(&self, state: &State, robot: usize) -> Areas {
        let needs = self.needs(state, robot).into_iter();
        needs
            .filter(|&area| self.lets_in(state, robot, area))
            .collect()
    }

    pub(super) fn stands_in(&self, state: &State, robot: usize) -> &Areas {
        &self.routes[robot].areas[usize::from(state.robots[robot].node)]
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
                );
            }
        }
        state.nets = nets;
    }

    /// Everything that can happen next.
    fn steps(&self, state: &State) -> Vec<(Step, State)> {
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

    /// It drives on where it has all areas for it.
    fn moves(&self, state: &State, robot: usize, steps: &mut Vec<(Step, State)>) {
        let (route, has) = (&self.routes[robot], self.has(state, robot));
        for &next in &route.next[usize::from(state.robots[robot].node)] {
            if route.areas[usize::from(next)]
                .iter()
                .all(|area| has.contains(area))
            {
                let mut after = state.clone();
                after.robots[robot] = RobotState {
                    node: next,
                    ahead: Areas::new(),
                };
                steps.push((Step::Moves(robot as u16), after));
            }
        }
    }

    /// It is granted an area.
    fn grants(&self, state: &State, robot: usize, steps: &mut Vec<(Step, State)>) {
        for area in self.needs(state, robot) {
            let place = usize::from(area);
            let may = self.governed_by[place].is_none() || self.lets_in(state, robot, area);
            let others = (0..self.routes.len()).filter(|&other| other != robot);
            let inside = others.filter(|&other| self.has(state, other).contains(&area));
            if may && inside.count() < self.capacities[place] {
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
