//! Robots and mediator on different machines: a binding over replicas, whose levels are lost, repeated and reordered.

use crate::analysis::{Limits, Use, check};
use crate::binding::NetBinding;
use crate::event::EventTable;
use crate::petri::{Binding, Budget, NetModel};
use crate::protocol::{FlagId, Level, Party, Replica, Side};
use proptest::prelude::*;

use super::area;

const ROBOTS: [&str; 3] = ["a", "b", "c"];

fn net_model() -> NetModel {
    let mut net = NetModel::new("crossing");
    net.place("free").mark("free");
    for robot in ROBOTS {
        let place = |what: &str| format!("{robot} {what}");
        let [asked, granted, left, inside] = ["asked", "granted", "left", "inside"].map(place);
        net.source(&asked, Binding::flag(robot, "request"));
        net.sink(&granted, Binding::flag(robot, "granted"));
        net.source(&left, Binding::flag(robot, "released"));
        net.place(&inside);
        net.transition(place("enters"), &[&asked, "free"], &[&inside, &granted]);
        net.transition(place("leaves"), &[&left, &inside], &["free"]);
    }
    net
}

struct Robot {
    side: Replica,
    request: FlagId,
    released: FlagId,
    is_inside: bool,
    crossed: u32,
    to_mediator: Vec<Level>,
    to_robot: Vec<Level>,
}

impl Robot {
    fn new(id: u16) -> Self {
        let protocol = area("mediator");
        let flag = |name| protocol.flag(name).unwrap();
        Self {
            request: flag("request"),
            released: flag("released"),
            side: Replica::new(&protocol, id, Party::First, 1),
            is_inside: false,
            crossed: 0,
            to_mediator: Vec::new(),
            to_robot: Vec::new(),
        }
    }

    /// Drives on, and looks at its flags.
    fn act(&mut self) {
        if self.is_inside {
            self.side.set(self.released).unwrap();
            self.is_inside = false;
            self.crossed += 1;
        } else {
            // Refused while it waits for the grant, or for the mediator to read the end of the last run.
            let _ = self.side.set(self.request);
        }
        // The mediator sets nothing but `granted`.
        self.is_inside |= self.side.poll().is_some();
    }
}

struct World {
    robots: Vec<Robot>,
    mediator: NetBinding<Replica>,
}

impl World {
    fn new() -> Self {
        let model = net_model();
        let uses = ROBOTS.map(|name| Use::new(name, area("mediator"), Party::Second));
        let proof = check(&model, &uses, &Limits::default()).unwrap();
        let net = model.compile(&mut EventTable::new()).unwrap();
        let sides = ROBOTS.iter().zip(0..).map(|(&name, id)| {
            let side = Replica::new(&area("mediator"), id, Party::Second, 1);
            (name, side)
        });
        Self {
            robots: (0..3).map(Robot::new).collect(),
            mediator: NetBinding::new(&proof, &net, sides).unwrap(),
        }
    }

    fn mediator_level(&self, robot: usize) -> Level {
        self.mediator.side(ROBOTS[robot]).unwrap().level()
    }

    fn tell_mediator(&mut self, robot: usize, level: Level) {
        let side = self.mediator.side_mut(ROBOTS[robot]).unwrap();
        side.merge(level).expect("both sides are honest");
    }

    fn tell_robot(&mut self, robot: usize, level: Level) {
        let merged = self.robots[robot].side.merge(level);
        merged.expect("both sides are honest");
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(128))]

    #[test]
    fn one_robot_at_a_time_whatever_the_network_does(
        steps in proptest::collection::vec((0..6_u8, 0..3_usize, any::<usize>()), 0..400),
    ) {
        let mut world = World::new();
        for (what, robot, number) in steps {
            match what {
                0 => world.robots[robot].act(),
                1 => {
                    world.mediator.step(Budget::default(), |_| true);
                }
                2 => {
                    let level = world.robots[robot].side.level();
                    world.robots[robot].to_mediator.push(level);
                }
                3 => {
                    let level = world.mediator_level(robot);
                    world.robots[robot].to_robot.push(level);
                }
                4 => {
                    let sent = &world.robots[robot].to_mediator;
                    if let Some(&level) = sent.get(number % sent.len().max(1)) {
                        world.tell_mediator(robot, level);
                    }
                }
                _ => {
                    let sent = &world.robots[robot].to_robot;
                    if let Some(&level) = sent.get(number % sent.len().max(1)) {
                        world.tell_robot(robot, level);
                    }
                }
            }
            prop_assert!(world.robots.iter().filter(|robot| robot.is_inside).count() <= 1);
        }
        // When the network works again, everybody gets across.
        let before: Vec<u32> = world.robots.iter().map(|robot| robot.crossed).collect();
        for _ in 0..30 {
            for robot in 0..3 {
                world.robots[robot].act();
                prop_assert!(world.robots.iter().filter(|robot| robot.is_inside).count() <= 1);
                let level = world.robots[robot].side.level();
                world.tell_mediator(robot, level);
                world.mediator.step(Budget::default(), |_| true);
                let level = world.mediator_level(robot);
                world.tell_robot(robot, level);
            }
        }
        for (robot, before) in world.robots.iter().zip(before) {
            prop_assert!(robot.crossed > before + 1);
        }
        prop_assert_eq!(world.mediator.refused(), 0);
    }
}
