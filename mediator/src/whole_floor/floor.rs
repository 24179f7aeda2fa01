//! A site as robots share it, and questions about a placement of them.

use std::sync::Arc;

use config::SiteConfig;
use description::keys::quoted_list;

use super::control_net::ControlNet;
use super::gate_net::GateNet;
use super::graph::Step;
use super::route::Route;
use super::state::{Areas, Phase, State, join};
use super::tokens::{Marks, Tokens};
use super::words::{bound, words};
use crate::nets::{Cast, Plan};

/// A site with its robots and its coordinations.
pub(super) struct Floor {
    pub(super) area_names: Vec<String>,
    pub(super) capacities: Vec<usize>,
    pub(super) routes: Vec<Route>,
    pub(super) gates: Vec<GateNet>,
    pub(super) controls: Vec<ControlNet>,
    /// By area: the net that decides about it.
    governed_by: Vec<Option<usize>>,
}

impl Floor {
    pub(super) fn new(site: &SiteConfig, plans: &[Arc<Plan>]) -> Self {
        let words = words(plans);
        let robots = site.robots.iter().enumerate();
        let routes = robots.filter_map(|(number, (id, robot))| {
            let fsm = site.fsm.get(&robot.role)?;
            let start = robot.start_state.as_ref().unwrap_or(&fsm.initial);
            let role = site.roles.get(&robot.role);
            let bound = bound(plans, &words, number);
            Some(Route {
                priority: role.map_or(0, |role| role.priority),
                ages: role.is_some_and(|role| role.ages_after > 0),
                ..Route::of(id, site, fsm, start, &bound)?
            })
        });
        let gates: Vec<GateNet> = { plans.iter() }
            .filter_map(|plan| GateNet::of(plan))
            .collect();
        let governed_by = (0..site.areas.len())
            .map(|area| { gates.iter() }.position(|net| net.governed.contains(&(area as u16))));
        Self {
            area_names: site.areas.iter().map(|area| area.id.clone()).collect(),
            capacities: { site.areas.iter() }
                .map(|area| area.capacity as usize)
                .collect(),
            routes: routes.collect(),
            governed_by: governed_by.collect(),
            gates,
            controls: { plans.iter() }
                .filter_map(|plan| ControlNet::of(plan, &words))
                .collect(),
        }
    }

    /// Without coordinations.
    #[cfg(test)]
    pub(super) fn of_routes(capacities: &[usize], routes: Vec<Route>) -> Self {
        let areas = 0..capacities.len();
        Self {
            area_names: areas.clone().map(|area| area.to_string()).collect(),
            capacities: capacities.to_vec(),
            routes,
            gates: Vec::new(),
            controls: Vec::new(),
            governed_by: areas.map(|_| None).collect(),
        }
    }

    /// A step in words, by what it leads to.
    pub(super) fn describe(&self, step: Step, after: &State) -> String {
        let robot = |robot: u16| &self.routes[usize::from(robot)].robot;
        let control = |net: u16| &self.controls[usize::from(net)];
        match step {
            Step::Heads(own) => {
                let state = &after.robots[usize::from(own)];
                let route = &self.routes[usize::from(own)];
                let way = usize::from(state.way.unwrap_or_default());
                let to = route.ways[usize::from(state.node)][way].to;
                let areas = &route.areas[usize::from(to)];
                format!("{} is to go on into {}", robot(own), self.names(areas))
            }
            Step::Moves(own) => {
                let areas = self.stands_in(after, own.into());
                format!("{} drives into {}", robot(own), self.names(areas))
            }
            Step::Turns(own) => {
                let areas = self.stands_in(after, own.into());
                format!("{} goes on in {}", robot(own), self.names(areas))
            }
            Step::IsGranted(own, area) => {
                let area = &self.area_names[usize::from(area)];
                format!("{} is granted `{area}`", robot(own))
            }
            Step::Asks(own, net) => {
                format!("{} asks `{}`", robot(own), self.gates[usize::from(net)].id)
            }
            Step::Fires(net, transition) => {
                let net = usize::from(net);
                let (id, tokens) = match net.checked_sub(self.gates.len()) {
                    None => (&self.gates[net].id, &self.gates[net].tokens),
                    // All situations are of one net.
                    Some(net) => (
                        &self.controls[net].id,
                        &self.controls[net].situations[0].tokens,
                    ),
                };
                format!("`{id}`: {}", Tokens::name(tokens, transition.into()))
            }
            Step::Begins(net, situation, _) => {
                let roles = &after.controls[usize::from(net)].roles;
                let robots: Vec<&str> = { roles.iter() }
                    .map(|role| robot(role.robot).as_str())
                    .collect();
                let own = control(net);
                format!(
                    "`{}` begins with {}: {}",
                    own.id,
                    robots.join(", "),
                    own.situations[usize::from(situation)].name
                )
            }
            Step::Hears(own, net) => {
                format!("{} hears what `{}` tells it", robot(own), control(net).id)
            }
            Step::Preempts(net) => format!(
                "`{}` stands still: its robots are told to get out of the way",
                control(net).id
            ),
            Step::Yielded(net) => {
                format!("robots of `{}` are out of the way", control(net).id)
            }
            Step::LetsGo(net) => format!("`{}` lets its robots go", control(net).id),
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

    /// The same of one area, without a list: this is asked most often.
    pub(super) fn has_area(&self, state: &State, robot: usize, area: u16) -> bool {
        self.stands_in(state, robot).contains(&area) || state.robots[robot].ahead.contains(&area)
    }

    /// What it lacks for going on, by all the ways that it may go, and for what it was ordered.
    pub(super) fn needs(&self, state: &State, robot: usize) -> Areas {
        let (route, own) = (&self.routes[robot], &state.robots[robot]);
        let node = usize::from(own.node);
        let mut needs = Areas::new();
        let lacks = |area: &u16| !self.has_area(state, robot, *area);
        let mut add = |areas: &Areas| join(&mut needs, areas.iter().copied().filter(lacks));
        if own.behind.is_some() {
            add(&route.areas[node]);
        } else {
            for way in &route.ways[node] {
                add(&route.areas[usize::from(way.to)]);
            }
        }
        add(&self.ordered(state, robot));
        needs
    }

    /// What it asks for: what it needs, or what it was ordered while its discrete control is taken.
    pub(super) fn asks(&self, state: &State, robot: usize) -> Areas {
        let taken = { state.controls.iter() }.any(|own| {
            ControlNet::role_of(own, robot).is_some_and(|role| ControlNet::is_acquired(own, role))
        });
        if !taken {
            return self.needs(state, robot);
        }
        let mut asks = self.ordered(state, robot);
        asks.retain(|area| !self.has_area(state, robot, *area));
        asks
    }

    /// Areas that it was ordered to ask for, and knows.
    fn ordered(&self, state: &State, robot: usize) -> Areas {
        let mut areas = Areas::new();
        for own in &state.controls {
            if let Some(role) = ControlNet::role_of(own, robot)
                && ControlNet::is_acquired(own, role)
            {
                join(&mut areas, ControlNet::ordered(own, role));
            }
        }
        areas
    }

    /// A coordination can take the robot's discrete control.
    pub(super) fn is_cast(&self, robot: usize) -> bool {
        let situations = self.controls.iter().flat_map(|net| &net.situations);
        let mut casts = situations.flat_map(|situation| &situation.casts);
        casts.any(|cast| cast.names(robot))
    }

    /// A net lets the robot into the area.
    pub(super) fn lets_in(&self, state: &State, robot: usize, area: u16) -> bool {
        self.governed_by[usize::from(area)].is_some_and(|net| {
            state.gates[net].begun && self.gates[net].lets_in(&state.gates[net], robot, area)
        })
    }

    /// A coordination keeps the area for the robot.
    pub(super) fn keeps(&self, state: &State, robot: usize, area: u16) -> bool {
        let mut roles = state.controls.iter().flat_map(|own| &own.roles);
        roles.any(|role| usize::from(role.robot) == robot && role.keeps(area))
    }

    /// What it lacks and a net keeps for it.
    pub(super) fn let_into(&self, state: &State, robot: usize) -> Areas {
        let mut needs = self.needs(state, robot);
        needs.retain(|&area| self.lets_in(state, robot, area) || self.keeps(state, robot, area));
        needs
    }

    pub(super) fn stands_in<'a>(&'a self, state: &'a State, robot: usize) -> &'a Areas {
        let own = &state.robots[robot];
        let here = &self.routes[robot].areas[usize::from(own.node)];
        own.behind.as_ref().unwrap_or(here)
    }

    /// The robot has somewhere to go.
    pub(super) fn goes_on(&self, state: &State, robot: usize) -> bool {
        let own = &state.robots[robot];
        own.behind.is_some() || self.routes[robot].leads_on[usize::from(own.node)]
    }

    /// Where it goes next, if that is decided, and no order can change it.
    pub(super) fn heads_for(&self, state: &State, robot: usize) -> Option<&Areas> {
        let (own, route) = (&state.robots[robot], &self.routes[robot]);
        let node = usize::from(own.node);
        if !route.orders[node].is_empty() || own.behind.is_some() {
            return None;
        }
        let way = &route.ways[node][usize::from(own.way?)];
        Some(&route.areas[usize::from(way.to)])
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
                    && self.asks(state, other).contains(&area)
                    && self.can_be_granted(state, other, area)
            })
    }

    /// It is a transition, and another one of its net is chosen before.
    pub(super) fn is_out_of_turn(&self, state: &State, step: Step) -> bool {
        let Step::Fires(net, transition) = step else {
            return false;
        };
        self.running(state, net.into())
            .is_some_and(|(tokens, marks)| tokens.is_out_of_turn(transition.into(), marks))
    }

    /// The net of this number, if it runs: first those that let robots into areas, then those that take discrete control.
    pub(super) fn running<'a>(
        &'a self,
        state: &'a State,
        number: usize,
    ) -> Option<(&'a Tokens, &'a Marks)> {
        let Some(control) = number.checked_sub(self.gates.len()) else {
            let own = &state.gates[number];
            return own
                .begun
                .then_some((&self.gates[number].tokens, &own.marks));
        };
        match &state.controls[control].phase {
            Phase::Running { situation, marks } => {
                let own = &self.controls[control].situations[usize::from(*situation)];
                Some((&own.tokens, marks))
            }
            Phase::Idle | Phase::Yielding => None,
        }
    }

    pub(super) fn can_be_granted(&self, state: &State, robot: usize, area: u16) -> bool {
        let place = usize::from(area);
        let others = (0..self.routes.len()).filter(|&other| other != robot);
        let inside = others.filter(|&other| self.has_area(state, other, area));
        let inside = inside.count();
        if self.keeps(state, robot, area) {
            return inside < self.capacities[place];
        }
        let taken = { state.controls.iter() }.any(|own| ControlNet::role_of(own, robot).is_some());
        let may = match self.governed_by[place] {
            Some(_) => self.lets_in(state, robot, area),
            None => !taken,
        };
        let kept = (0..self.routes.len())
            .filter(|&other| self.keeps(state, other, area))
            .filter(|&other| !self.has_area(state, other, area));
        may && inside + kept.count() < self.capacities[place]
    }

    /// A robot is as a situation wants it, as far as areas and its machine show it.
    pub(super) fn fits(&self, state: &State, robot: usize, cast: &Cast) -> bool {
        let (has, asks) = (self.has(state, robot), self.asks(state, robot));
        let stands_in = self.stands_in(state, robot);
        let all = |wanted: &[usize], areas: &Areas| {
            wanted.iter().all(|&area| areas.contains(&(area as u16)))
        };
        let none = |wanted: &[usize], areas: &Areas| {
            !wanted.iter().any(|&area| areas.contains(&(area as u16)))
        };
        let node = state.robots[robot].node;
        cast.names(robot)
            && all(&cast.holds, &has)
            && all(&cast.stands_in, stands_in)
            && none(&cast.without, &has)
            && all(&cast.asks, &asks)
            && (cast.states.is_empty() || self.routes[robot].is_one_of(node, &cast.states))
    }
}

#[cfg(test)]
mod tests {
    use super::super::tests::{plans_of, shipped_net, site, text};
    use super::*;
    use crate::setup::Setup;

    /// As the file says it, robots are let in and floors are judged.
    #[test]
    fn priorities_and_their_ageing_come_from_the_site_file() {
        let shipped = text("sites/overtaking");
        let aged = shipped.replace("priority = 1\n", "priority = 3\nages_after = 5\n");
        for (text, emergency) in [(&shipped, (1, 0)), (&aged, (3, 5))] {
            let site = site(text);
            let setup = Setup::of(&site).expect("a good site");
            let plans = plans_of(&site, &setup, &[shipped_net("overtaking")]);
            let floor = Floor::new(&site, &plans);
            for robot in &setup.robots {
                let expected = match robot.role.as_str() {
                    "emergency" => emergency,
                    _ => (0, 0),
                };
                assert_eq!((robot.priority, robot.ages_after), expected, "{}", robot.id);
                let route = { floor.routes.iter() }.find(|route| route.robot == robot.id);
                let route = route.expect("it drives");
                let (priority, ages_after) = expected;
                assert_eq!((route.priority, route.ages), (priority, ages_after > 0));
            }
        }
    }
}
