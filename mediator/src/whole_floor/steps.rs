//! What can happen next.

use super::control_net::{ControlNet, assignments};
use super::floor::Floor;
use super::graph::Step;
use super::route::Way;
use super::state::{Areas, Phase, State, join};

impl Floor {
    /// What follows by itself.
    pub(super) fn follow(&self, state: &mut State) {
        for (net, own) in self.controls.iter().zip(&mut state.controls) {
            net.follow(own);
        }
        for robot in 0..self.routes.len() {
            while self.obey(state, robot) {}
        }
        let mut gates = std::mem::take(&mut state.gates);
        for (net, own) in self.gates.iter().zip(&mut gates) {
            let robots = 0..self.routes.len();
            let is_empty =
                |area: &u16| { robots.clone() }.all(|robot| !self.has_area(state, robot, *area));
            own.begun = own.begun || own.may_begin() && net.governed.iter().all(is_empty);
            if own.begun {
                net.follow(
                    own,
                    |robot, area| self.has_area(state, robot, area),
                    |robot, area| self.stands_in(state, robot).contains(&area),
                    |robot, area| self.asks(state, robot).contains(&area),
                );
            }
        }
        state.gates = gates;
        for (route, own) in self.routes.iter().zip(&mut state.robots) {
            if own.behind.is_none() && route.ways[usize::from(own.node)].len() == 1 {
                own.way = Some(0);
            }
        }
    }

    /// The robot's machine takes its next order, or has no use for it.
    fn obey(&self, state: &mut State, robot: usize) -> bool {
        let own = &mut state.robots[robot];
        let Some(&order) = own.orders.first() else {
            return false;
        };
        let known = &self.routes[robot].orders[usize::from(own.node)];
        let way = known.iter().find(|(event, _)| *event == order.event);
        if way.is_none() && !order.releases && own.orders.len() == 1 {
            // Its machine may come to where it has.
            return false;
        }
        own.orders.remove(0);
        if let Some((_, way)) = way {
            self.go(state, robot, way);
        }
        // What it has answered may be read at once.
        for (net, own) in self.controls.iter().zip(&mut state.controls) {
            net.follow(own);
        }
        true
    }

    /// The robot's machine goes this way. The robot itself follows once it has all areas for it.
    fn go(&self, state: &mut State, robot: usize, way: &Way) {
        let there = &self.routes[robot].areas[usize::from(way.to)];
        let has = self.has(state, robot);
        let stands_in = self.stands_in(state, robot).clone();
        let own = &mut state.robots[robot];
        (own.node, own.way) = (way.to, None);
        if there.iter().all(|area| has.contains(area)) {
            own.behind = None;
            self.leave(state, robot, &has, &stands_in);
        } else {
            own.behind = Some(stands_in);
        }
        for &output in &way.outputs {
            for (net, own) in self.controls.iter().zip(&mut state.controls) {
                if let Some(role) = ControlNet::role_of(own, robot) {
                    net.put_out(own, role, output);
                }
            }
        }
    }

    /// Of what it had, the robot keeps where it stands now, and what it was ordered into.
    fn leave(&self, state: &mut State, robot: usize, had: &Areas, stood_in: &Areas) {
        let here = self.stands_in(state, robot).clone();
        let kept: Areas = { state.robots[robot].ahead.iter().copied() }
            .filter(|area| !here.contains(area) && self.keeps(state, robot, *area))
            .collect();
        for &area in had {
            if !here.contains(&area) && !kept.contains(&area) {
                let entered = stood_in.contains(&area);
                for (net, own) in self.controls.iter().zip(&mut state.controls) {
                    net.gave_back(own, robot, area, entered);
                }
            }
        }
        state.robots[robot].ahead = kept;
    }

    /// Everything that can happen next.
    pub(super) fn steps(&self, state: &State) -> Vec<(Step, State)> {
        // Nothing else can make a difference to that, nor it to anything else but the robot's own way.
        let open = (0..self.routes.len()).find(|&robot| {
            let own = &state.robots[robot];
            let ways = &self.routes[robot].ways[usize::from(own.node)];
            own.behind.is_none() && own.way.is_none() && !ways.is_empty()
        });
        if let Some(robot) = open {
            return self.ways(state, robot);
        }
        let mut steps = Vec::new();
        if let Some(only) = self.firings(state, &mut steps) {
            return vec![only];
        }
        for robot in 0..self.routes.len() {
            self.moves(state, robot, &mut steps);
            self.grants(state, robot, &mut steps);
            self.questions(state, robot, &mut steps);
            self.hearings(state, robot, &mut steps);
        }
        self.beginnings(state, &mut steps);
        self.yieldings(state, &mut steps);
        steps
    }

    /// Transitions of nets; one alone where nothing else can make a difference to it, nor it to anything else.
    fn firings(&self, state: &State, steps: &mut Vec<(Step, State)>) -> Option<(Step, State)> {
        for number in 0..self.gates.len() + self.controls.len() {
            let Some((tokens, marks)) = self.running(state, number) else {
                continue;
            };
            let enabled = tokens.enabled(marks);
            for &transition in &enabled {
                let mut after = state.clone();
                if let Some(marks) = after.marks_mut(number) {
                    tokens.fire(marks, transition);
                }
                let step = Step::Fires(number as u16, transition as u16);
                if enabled.len() == 1 && tokens.is_free(transition) {
                    return Some((step, after));
                }
                steps.push((step, after));
            }
        }
        None
    }

    /// It turns out where it goes next. What decides that, such as what it sees, does not ask which way is free.
    fn ways(&self, state: &State, robot: usize) -> Vec<(Step, State)> {
        let ways = &self.routes[robot].ways[usize::from(state.robots[robot].node)];
        let ways = (0..ways.len()).map(|way| {
            let mut after = state.clone();
            after.robots[robot].way = Some(way as u16);
            (Step::Heads(robot as u16), after)
        });
        ways.collect()
    }

    /// It drives on where it has all areas for it.
    fn moves(&self, state: &State, robot: usize, steps: &mut Vec<(Step, State)>) {
        let (own, route) = (&state.robots[robot], &self.routes[robot]);
        let node = usize::from(own.node);
        let way = match (&own.behind, own.way) {
            // Its machine is there already.
            (Some(_), _) => Way {
                to: own.node,
                outputs: Vec::new(),
            },
            (None, Some(way)) => route.ways[node][usize::from(way)].clone(),
            (None, None) => return,
        };
        let there = &route.areas[usize::from(way.to)];
        if { there.iter() }.all(|area| self.has_area(state, robot, *area)) {
            let mut after = state.clone();
            self.go(&mut after, robot, &way);
            let stays = self.stands_in(state, robot) == there;
            let step = if stays { Step::Turns } else { Step::Moves };
            steps.push((step(robot as u16), after));
        }
    }

    /// It is granted an area.
    fn grants(&self, state: &State, robot: usize, steps: &mut Vec<(Step, State)>) {
        for area in self.asks(state, robot) {
            if self.can_be_granted(state, robot, area) {
                let mut after = state.clone();
                join(&mut after.robots[robot].ahead, [area]);
                let roles = after.controls.iter_mut().flat_map(|own| &mut own.roles);
                { roles.filter(|role| usize::from(role.robot) == robot) }
                    .for_each(|role| role.granted(area));
                steps.push((Step::IsGranted(robot as u16, area), after));
            }
        }
    }

    /// It asks for the areas of a passage.
    fn questions(&self, state: &State, robot: usize, steps: &mut Vec<(Step, State)>) {
        let asks = self.asks(state, robot);
        let is_in = |areas: &Areas, area: &usize| areas.contains(&(*area as u16));
        let has = |robot: usize, area: &usize| self.has_area(state, robot, *area as u16);
        for (number, net) in self.gates.iter().enumerate() {
            let own = &state.gates[number];
            let wants = |other: usize, areas: &[usize]| {
                let asks = self.asks(state, other);
                areas
                    .iter()
                    .any(|area| has(other, area) || is_in(&asks, area))
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
                    .all(|area| has(robot, area) || is_in(&asks, area))
                    && passage.areas.iter().any(|area| is_in(&asks, area))
            });
            if let Some(passage) = passage {
                let mut after = state.clone();
                net.ask(&mut after.gates[number], role, robot, passage);
                steps.push((Step::Asks(robot as u16, number as u16), after));
            }
        }
    }

    /// It hears what it was told.
    fn hearings(&self, state: &State, robot: usize, steps: &mut Vec<(Step, State)>) {
        for (number, net) in self.controls.iter().enumerate() {
            let Some(role) = ControlNet::role_of(&state.controls[number], robot) else {
                continue;
            };
            if !ControlNet::has_news(&state.controls[number], role) {
                continue;
            }
            let mut after = state.clone();
            let orders = &mut after.robots[robot].orders;
            net.hear(&mut after.controls[number], role, orders);
            // It gives back what it was not ordered into.
            let released = net.has_released(&after.controls[number], role);
            self.give_back(&mut after, robot, released);
            steps.push((Step::Hears(robot as u16, number as u16), after));
        }
    }

    /// A robot whose discrete control is taken gives back what it is not in and was not ordered into; one that has it again, what its
    /// machine does not go on into.
    fn give_back(&self, state: &mut State, robot: usize, released: bool) {
        let own = &state.robots[robot];
        let route = &self.routes[robot];
        let node = usize::from(own.node);
        let is_next = |area: &u16| {
            let ways = route.ways[node].iter().map(|way| way.to);
            ways.chain([own.node])
                .any(|to| route.areas[usize::from(to)].contains(area))
        };
        let (keeps, gives): (Areas, Areas) = { own.ahead.iter().copied() }.partition(|area| {
            if released {
                is_next(area)
            } else {
                self.keeps(state, robot, *area)
            }
        });
        state.robots[robot].ahead = keeps;
        for area in gives {
            for (net, own) in self.controls.iter().zip(&mut state.controls) {
                net.gave_back(own, robot, area, false);
            }
        }
    }

    /// A coordination begins with robots that are as one of its situations wants them.
    fn beginnings(&self, state: &State, steps: &mut Vec<(Step, State)>) {
        let count = self.routes.len();
        let is_free = |robot: usize| {
            let mut controls = state.controls.iter();
            controls.all(|own| ControlNet::role_of(own, robot).is_none())
        };
        for (number, net) in self.controls.iter().enumerate() {
            if state.controls[number].phase != Phase::Idle {
                continue;
            }
            for (situation, own) in net.situations.iter().enumerate() {
                let fitting = own.casts.iter().map(|cast| {
                    let robots = (0..count).filter(|&robot| is_free(robot));
                    robots
                        .filter(|&robot| self.fits(state, robot, cast))
                        .collect()
                });
                // One more than there is room for is enough to say that there are too many.
                let most = (self.most() + 1).saturating_sub(steps.len());
                for robots in assignments(&fitting.collect::<Vec<Vec<usize>>>(), most) {
                    // Tells those of few robots apart; of many some are the same.
                    let who = robots.iter().fold(0_u32, |who, &robot| {
                        who.wrapping_mul(count as u32).wrapping_add(robot as u32)
                    });
                    let mut after = state.clone();
                    let robots = robots.into_iter().map(|robot| robot as u16);
                    after.controls[number] = net.start(situation, robots);
                    let step = Step::Begins(number as u16, situation as u16, who);
                    steps.push((step, after));
                }
            }
        }
    }

    /// Robots of coordinations are told to get out of the way, are out of it, or are let go.
    fn yieldings(&self, state: &State, steps: &mut Vec<(Step, State)>) {
        for (number, net) in self.controls.iter().enumerate() {
            let own = &state.controls[number];
            let robot = |role: usize| usize::from(own.roles[role].robot);
            if let Some(yielding) = net.preempt(own) {
                let mut after = state.clone();
                { own.roles.iter() }
                    .for_each(|role| after.robots[usize::from(role.robot)].orders.clear());
                after.controls[number] = yielding;
                steps.push((Step::Preempts(number as u16), after));
            }
            let is_in = |role: usize, states: &[String]| {
                let node = state.robots[robot(role)].node;
                self.routes[robot(role)].is_one_of(node, states)
            };
            let fits = |role: usize, cast: &_| self.fits(state, robot(role), cast);
            if let Some(next) = net.yielded(own, is_in, fits) {
                let mut after = state.clone();
                after.controls[number] = next;
                steps.push((Step::Yielded(number as u16), after));
            }
            if net.may_let_go(own) {
                let mut after = state.clone();
                for role in (0..own.roles.len()).filter(|&role| !own.roles[role].over) {
                    let orders = &mut after.robots[robot(role)].orders;
                    orders.clear();
                    orders.extend(net.let_go(own, role));
                }
                after.controls[number] = ControlNet::idle();
                for role in 0..own.roles.len() {
                    self.give_back(&mut after, robot(role), true);
                }
                steps.push((Step::LetsGo(number as u16), after));
            }
        }
    }
}
