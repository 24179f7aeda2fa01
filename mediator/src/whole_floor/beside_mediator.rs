//! The floor beside the mediator itself: wherever the manager and robots that run their machines get to, the floor has been.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

use config::SiteConfig;
use contract::client::{Client, Order, Situation};
use contract::wire::Control;
use description::site::{FsmConfig, FsmTransition};

use super::floor::Floor;
use super::state::Phase;
use super::tests::{plans_of, shipped_net, site, text};
use super::words::{bound, words};
use crate::journal::Stored;
use crate::manager::Manager;
use crate::nets::Plan;
use crate::setup::Setup;

const MS_NS: u64 = 1_000_000;
const SILENT_AFTER_NS: u64 = 1_000_000_000;
/// Of each seed.
const STEPS: usize = 400;

/// What both show of a placement: by robot the node of its machine and the areas that it has; whether a coordination has control.
type View = (Vec<(u16, Vec<String>)>, bool);

/// A robot with the machine of its role.
struct Robot<'a> {
    id: &'a str,
    fsm: &'a FsmConfig,
    client: Client,
    state: String,
    /// What its machine will do next by itself, of all it can.
    next: usize,
    stands_in: Vec<String>,
    orders: Vec<Order>,
    /// It hears nothing new of coordinations for so many steps. What becomes of its grants, the floor takes it to hear at once.
    deaf: u32,
    heard: Option<Control>,
    /// How often it has driven on to other areas.
    moves: usize,
}

/// SplitMix64 (Steele et al. 2014).
struct Random(u64);

impl Random {
    fn below(&mut self, end: usize) -> usize {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) % end.max(1) as u64) as usize
    }
}

impl Robot<'_> {
    fn areas_of(&self, state: &str) -> Vec<String> {
        let state = self.fsm.state(state).expect("a state of its own");
        state.areas().map(str::to_owned).collect()
    }

    /// Transitions that its machine makes by itself.
    fn own_transitions(&self, orders: &BTreeSet<String>) -> Vec<FsmTransition> {
        let all = self.fsm.transitions.iter();
        all.filter(|own| own.from == self.state && !orders.contains(&own.on))
            .cloned()
            .collect()
    }

    fn situation(&self, orders: &BTreeSet<String>) -> Situation {
        let mut wanted = self.stands_in.clone();
        wanted.extend(self.areas_of(&self.state));
        for own in self.own_transitions(orders) {
            wanted.extend(self.areas_of(&own.to));
        }
        let mut seen = BTreeSet::new();
        wanted.retain(|area| seen.insert(area.clone()));
        Situation {
            located: true,
            stands_in: self.stands_in.clone(),
            wanted,
            fsm_state: self.state.clone(),
            ..Situation::default()
        }
    }

    fn may_be_in(&self, areas: &[String]) -> bool {
        let mut areas = areas.iter();
        areas.all(|area| self.stands_in.contains(area) || self.client.holds(area))
    }

    /// Goes on where its machine has come to, as soon as it has all areas for that.
    fn arrive(&mut self) -> bool {
        let there = self.areas_of(&self.state);
        let arrives = self.stands_in != there && self.may_be_in(&there);
        if arrives {
            self.stands_in = there;
            self.moves += 1;
        }
        arrives
    }

    fn take(&mut self, transition: &FsmTransition) {
        self.state.clone_from(&transition.to);
        let there = self.areas_of(&self.state);
        if self.may_be_in(&there) {
            self.moves += usize::from(self.stands_in != there);
            self.stands_in = there;
        }
        for output in &transition.outputs {
            self.client.output(output);
        }
    }

    /// Its machine takes what it was ordered.
    fn obey(&mut self) -> bool {
        self.orders
            .extend(std::iter::from_fn(|| self.client.next_order()));
        let Some(order) = self.orders.first() else {
            return false;
        };
        let Some(event) = order.instruction.event.clone() else {
            self.orders.remove(0);
            return true;
        };
        let mut transitions = self.fsm.transitions.iter();
        let found = transitions.find(|own| own.from == self.state && own.on == event);
        if let Some(own) = found {
            self.orders.remove(0);
            self.take(&own.clone());
            return true;
        }
        if order.flag == "release" || self.orders.len() > 1 {
            self.orders.remove(0);
            return true;
        }
        false
    }
}

struct Scene<'a> {
    manager: Manager,
    robots: Vec<Robot<'a>>,
    orders: BTreeSet<String>,
    now_ns: u64,
}

impl<'a> Scene<'a> {
    fn new(
        site: &'a SiteConfig,
        setup: &Setup,
        plans: &[Arc<Plan>],
        orders: &BTreeSet<String>,
        random: &mut Random,
    ) -> Self {
        let robots = site.robots.iter().map(|(id, robot)| {
            let fsm = &site.fsm[&robot.role];
            let state = robot.start_state.as_ref().unwrap_or(&fsm.initial);
            let mut own = Robot {
                id,
                fsm,
                client: Client::new(id, &setup.site, 5).on(setup.floor.clone()),
                state: state.clone(),
                next: random.below(8),
                stands_in: Vec::new(),
                orders: Vec::new(),
                deaf: 0,
                heard: None,
                moves: 0,
            };
            own.stands_in = own.areas_of(state);
            own
        });
        let mut scene = Self {
            robots: robots.collect(),
            manager: Manager::with_plans(setup, plans.to_vec(), &Stored::new(1), 0).expect("valid"),
            orders: orders.clone(),
            // No robot may still enter what an earlier manager has granted.
            now_ns: 10_000 * MS_NS,
        };
        scene.talk();
        scene
    }

    /// All talk until nobody has news, and machines take their orders.
    fn talk(&mut self) {
        for _ in 0..24 {
            let mut news = false;
            for robot in &mut self.robots {
                let situation = robot.situation(&self.orders);
                robot.client.step(situation, self.now_ns, SILENT_AFTER_NS);
                self.manager.report(&robot.client.report(), self.now_ns);
            }
            while let Some(message) = self.manager.next_message(self.now_ns) {
                for robot in &mut self.robots {
                    if message.robot_id != robot.id {
                        continue;
                    }
                    let mut message = message.clone();
                    if robot.deaf > 0 {
                        message.control.clone_from(&robot.heard);
                    }
                    robot.heard.clone_from(&message.control);
                    robot.client.receive(&message, self.now_ns);
                    news = true;
                }
            }
            for robot in &mut self.robots {
                while robot.obey() {
                    news = true;
                }
            }
            self.now_ns += MS_NS;
            if !news {
                break;
            }
        }
        self.manager.tick(self.now_ns);
    }

    fn view(&self, floor: &Floor) -> View {
        let status = self.manager.status(self.now_ns);
        let has = |id: &str| -> Vec<String> {
            let areas = status.areas.iter().filter(|area| {
                let mut holders = area.holders.iter();
                holders.any(|(robot, _)| robot == id) || area.standing.iter().any(|own| own == id)
            });
            areas.map(|area| area.id.clone()).collect()
        };
        let robots = self.robots.iter().zip(&floor.routes).map(|(own, route)| {
            let mut states = route.states.iter();
            let node = states.find(|(name, _)| *name == own.state);
            (node.map_or(u16::MAX, |(_, node)| *node), has(own.id))
        });
        let runs = status.coordinations.iter().any(|own| !own.over);
        (robots.collect(), runs)
    }

    /// Something happens, by chance.
    fn happens(&mut self, random: &mut Random) {
        let number = random.below(self.robots.len());
        match random.below(40) {
            // So long that coordinations that stand still are broken off.
            0 => {
                self.robots.iter_mut().for_each(|robot| robot.deaf = 0);
                for _ in 0..140 {
                    self.now_ns += 500 * MS_NS;
                    self.talk();
                }
            }
            1..5 => self.robots[number].deaf = 1 + random.below(6) as u32,
            _ => {
                let robot = &mut self.robots[number];
                if !robot.arrive() && robot.stands_in == robot.areas_of(&robot.state) {
                    let transitions = robot.own_transitions(&self.orders);
                    if let Some(own) = transitions.get(robot.next % transitions.len().max(1))
                        && robot.may_be_in(&robot.areas_of(&own.to))
                    {
                        robot.take(own);
                        robot.next = random.below(8);
                    }
                }
            }
        }
        for robot in &mut self.robots {
            robot.deaf = robot.deaf.saturating_sub(1);
        }
        self.talk();
    }
}

/// Lets robots drive on one site, and looks where they get to on the floor of another: how many places of robots' machines that were,
/// and how many the floor knows. An error names the first that it does not know, or a robot that drives no more.
fn compare(
    driven: &SiteConfig,
    looked_at: &SiteConfig,
    net: &str,
    seeds: u64,
) -> Result<(usize, usize), String> {
    let setup = Setup::of(driven).expect("a good site");
    let plans = plans_of(driven, &setup, &[shipped_net(net)]);
    let floor = Floor::new(looked_at, &plans);
    let explored = floor.explore();
    assert!(explored.is_whole(), "{net} is too large");
    let graph = explored.graph;
    let mut known: BTreeMap<View, bool> = BTreeMap::new();
    for state in &graph.states {
        let robots = (0..floor.routes.len()).map(|robot| {
            let has = floor.has(state, robot).into_iter().map(usize::from);
            let names = has.map(|area| floor.area_names[area].clone());
            (state.robots[robot].node, names.collect())
        });
        let runs = state.gates.iter().any(|own| own.begun) || { state.controls.iter() }
            .any(|own| own.phase != Phase::Idle);
        known.insert((robots.collect(), runs), false);
    }
    let words = words(&plans);
    let orders: BTreeSet<String> = (0..driven.robots.len())
        .flat_map(|robot| bound(&plans, &words, robot).events.into_keys())
        .map(str::to_owned)
        .collect();
    for seed in 0..seeds {
        let mut random = Random(seed);
        let mut scene = Scene::new(driven, &setup, &plans, &orders, &mut random);
        for step in 0..STEPS {
            if step == STEPS / 2 {
                scene.robots.iter_mut().for_each(|robot| robot.moves = 0);
            }
            let view = scene.view(&floor);
            match known.get_mut(&view) {
                Some(seen) => *seen = true,
                None => return Err(format!("seed {seed}, step {step}: {view:?}")),
            }
            scene.happens(&mut random);
        }
        if let Some(still) = scene.robots.iter().find(|robot| robot.moves == 0) {
            return Err(format!("seed {seed}: {} drives no more", still.id));
        }
    }
    // Who is where: in which order areas are granted before that, is none of the robots' choice here.
    let nodes = |is_seen: bool| {
        let places = known.iter().filter(|(_, seen)| !is_seen || **seen);
        let nodes: BTreeSet<Vec<u16>> = places
            .map(|((robots, _), _)| robots.iter().map(|(node, _)| *node).collect())
            .collect();
        nodes.len()
    };
    Ok((nodes(true), nodes(false)))
}

#[test]
fn the_floor_has_been_wherever_the_mediator_lets_robots_get_to_and_nobody_waits_for_ever() {
    for name in ["overtaking", "t-junction", "docking"] {
        let site = site(&text(&format!("sites/{name}")));
        let (seen, all) =
            compare(&site, &site, name, 12).unwrap_or_else(|what| panic!("{name}, {what}"));
        println!("{name}: {seen} of {all} places of robots' machines");
        assert!(2 * seen > all, "{name}: {seen} of {all}");
    }
}

#[test]
fn a_floor_that_is_not_the_mediators_is_noticed() {
    for name in ["overtaking", "t-junction", "docking"] {
        let shipped = text(&format!("sites/{name}"));
        let roomy = site(&shipped.replace("capacity = 1", "capacity = 2"));
        let found = compare(&roomy, &site(&shipped), name, 12);
        assert!(found.is_err(), "{name}: {found:?}");
    }
}
