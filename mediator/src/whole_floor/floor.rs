//! A site as robots share it, and questions about a placement of them.

use std::sync::Arc;

use config::SiteConfig;
use description::keys::quoted_list;

use super::gate_net::GateNet;
use super::graph::Step;
use super::route::Route;
use super::state::{Areas, State, join};
use crate::nets::Plan;

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
            let role = site.roles.get(&robot.role);
            Some(Route {
                priority: role.map_or(0, |role| role.priority),
                ages: role.is_some_and(|role| role.ages_after > 0),
                ..Route::of(id, site, fsm, start)?
            })
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

    /// Without nets.
    #[cfg(test)]
    pub(super) fn of_routes(capacities: &[usize], routes: Vec<Route>) -> Self {
        let areas = 0..capacities.len();
        Self {
            area_names: areas.clone().map(|area| area.to_string()).collect(),
            capacities: capacities.to_vec(),
            routes,
            nets: Vec::new(),
            governed_by: areas.map(|_| None).collect(),
        }
    }

    /// A step in words, by what it leads to.
    pub(super) fn describe(&self, step: Step, after: &State) -> String {
        let robot = |robot: u16| &self.routes[usize::from(robot)].robot;
        match step {
            Step::Heads(own) => {
                let to = after.robots[usize::from(own)].to.unwrap_or_default();
                let areas = &self.routes[usize::from(own)].areas[usize::from(to)];
                format!("{} is to go on into {}", robot(own), self.names(areas))
            }
            Step::Moves(own) => {
                let areas = self.stands_in(after, own.into());
                format!("{} drives into {}", robot(own), self.names(areas))
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

    fn names(&self, areas: &Areas) -> String {
        let names = { areas.iter() }.map(|&area| self.area_names[usize::from(area)].as_str());
        quoted_list(&names.collect::<Vec<&str>>(), "and")
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
    pub(super) fn lets_in(&self, state: &State, robot: usize, area: u16) -> bool {
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

    /// The robot has somewhere to go.
    pub(super) fn goes_on(&self, state: &State, robot: usize) -> bool {
        !self.routes[robot].next[usize::from(state.robots[robot].node)].is_empty()
    }

    /// Robots that wait for each other, whatever the rest does; where nothing can happen any more, all that go on.
    pub(super) fn who_waits_for_ever(&self, state: &State, nothing_happens: bool) -> Vec<usize> {
        let robots = 0..self.routes.len();
        if nothing_happens {
            return robots.filter(|&own| self.goes_on(state, own)).collect();
        }
        let mut waits: Vec<usize> = robots.collect();
        loop {
            let is_full = |area: u16, without: usize| {
                let others = waits.iter().filter(|&&other| other != without);
                let inside = others.filter(|&&other| self.has(state, other).contains(&area));
                inside.count() >= self.capacities[usize::from(area)]
            };
            let is_held_up = |&robot: &usize| {
                let to = state.robots[robot].to;
                let areas = to.map(|to| &self.routes[robot].areas[usize::from(to)]);
                let has = self.has(state, robot);
                let mut lacks = areas
                    .into_iter()
                    .flatten()
                    .filter(|area| !has.contains(area));
                lacks.any(|&area| is_full(area, robot))
            };
            let left: Vec<usize> = waits.iter().copied().filter(is_held_up).collect();
            if left.len() == waits.len() {
                return left;
            }
            waits = left;
        }
    }

    /// It is a grant, and a robot of a larger priority can be granted that area now, if it asks for it already.
    pub(super) fn is_outranked(&self, state: &State, step: Step) -> bool {
        let Step::IsGranted(robot, area) = step else {
            return false;
        };
        let own = &self.routes[usize::from(robot)];
        let mut others = 0..self.routes.len();
        !own.ages
            && others.any(|other| {
                self.routes[other].priority > own.priority
                    && self.needs(state, other).contains(&area)
                    && self.can_be_granted(state, other, area)
            })
    }

    pub(super) fn can_be_granted(&self, state: &State, robot: usize, area: u16) -> bool {
        let place = usize::from(area);
        let may = self.governed_by[place].is_none() || self.lets_in(state, robot, area);
        let others = (0..self.routes.len()).filter(|&other| other != robot);
        let inside = others.filter(|&other| self.has(state, other).contains(&area));
        may && inside.count() < self.capacities[place]
    }
}
