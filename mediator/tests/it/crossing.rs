//! A net with fewer roles than there are robots that come.

use std::sync::Arc;

use contract::client::{Client, Situation};
use contract::timing::SILENT_AFTER_NS;
use mediator::journal::Stored;
use mediator::manager::Manager;
use mediator::nets::Plan;
use mediator::setup::Setup;

use crate::sites;

const ROBOTS: usize = 6;
const STEP_NS: u64 = 100_000_000;
/// Steps that a robot stays on the crossing, and away from it.
const STAYS: u64 = 3;

struct Robot {
    client: Client,
    inside: bool,
    next: u64,
    crossings: u32,
}

/// The crossing, and whoever comes there.
struct Crossing {
    setup: Setup,
    plans: Vec<Arc<Plan>>,
    stored: Stored,
    manager: Manager,
    robots: Vec<Robot>,
    step: u64,
    /// It is not heard, and stands where it is.
    silent: Option<usize>,
}

impl Crossing {
    fn new() -> Self {
        let (setup, plans) = sites::crossing(ROBOTS);
        let stored = Stored::new(1);
        let manager = Manager::with_plans(&setup, plans.clone(), &stored, 0).expect("valid");
        let robots = { setup.robots.iter() }.map(|robot| Robot {
            client: Client::new(&robot.id, &setup.site, 5).on(setup.floor.clone()),
            inside: false,
            next: 0,
            crossings: 0,
        });
        Self {
            robots: robots.collect(),
            setup,
            plans,
            stored,
            manager,
            step: 0,
            silent: None,
        }
    }

    fn now_ns(&self) -> u64 {
        self.step * STEP_NS
    }

    fn run(&mut self, steps: u64) {
        for _ in 0..steps {
            self.go_on();
        }
    }

    fn go_on(&mut self) {
        let (step, now_ns) = (self.step, self.now_ns());
        for (number, robot) in self.robots.iter_mut().enumerate() {
            if self.silent == Some(number) {
                continue;
            }
            if robot.inside && step >= robot.next {
                (robot.inside, robot.next) = (false, step + STAYS);
                robot.crossings += 1;
            } else if !robot.inside && robot.client.may_be_in("Cr", now_ns) {
                (robot.inside, robot.next) = (true, step + STAYS);
            }
            let room = format!("room-{number}");
            let wants = robot.inside || step >= robot.next;
            let crossing = |is: bool| is.then(|| "Cr".to_owned());
            let situation = Situation {
                located: true,
                stands_in: [Some(room.clone()), crossing(robot.inside)]
                    .into_iter()
                    .flatten()
                    .collect(),
                wanted: [Some(room), crossing(wants)]
                    .into_iter()
                    .flatten()
                    .collect(),
                ..Situation::default()
            };
            robot.client.step(situation, now_ns, SILENT_AFTER_NS);
            self.manager.report(&robot.client.report(), now_ns);
        }
        self.manager.tick(now_ns);
        self.manager
            .entries()
            .for_each(|entry| self.stored.apply(entry));
        while let Some(message) = self.manager.next_message(now_ns) {
            let others = self.robots.iter_mut().enumerate();
            for (_, robot) in others.filter(|(number, _)| self.silent != Some(*number)) {
                robot.client.receive(&message, now_ns);
            }
        }
        let inside = self.robots.iter().filter(|robot| robot.inside).count();
        assert!(inside <= 1, "{inside} at step {step}");
        self.step += 1;
    }

    fn restart(&mut self) {
        let (plans, now_ns) = (self.plans.clone(), self.now_ns());
        self.manager =
            Manager::with_plans(&self.setup, plans, &self.stored, now_ns).expect("its own");
    }

    /// The robot has asked for the crossing, and has not got it.
    fn waits(&self, robot: usize) -> bool {
        let status = self.manager.status(self.now_ns());
        let crossing = status.areas.last().expect("the crossing");
        let id = &self.setup.robots[robot].id;
        assert_eq!(crossing.id, "Cr");
        crossing.waiting.contains(id)
    }

    fn holders(&self) -> Vec<(String, u64)> {
        let status = self.manager.status(self.now_ns());
        status.areas.last().expect("the crossing").holders.clone()
    }

    /// Until it waits, which is when it is heard last.
    fn loses(&mut self, robot: usize) {
        let until = self.step + 200;
        while !self.waits(robot) {
            self.go_on();
            assert!(self.step < until, "robot {robot} does not come");
        }
        self.silent = Some(robot);
    }

    /// All but the silent one come again and again.
    fn assert_goes_on(&mut self, steps: u64, what: &str) {
        let before: Vec<u32> = self.robots.iter().map(|robot| robot.crossings).collect();
        self.run(steps);
        for (number, robot) in self.robots.iter().enumerate() {
            let crossings = robot.crossings - before[number];
            assert!(
                self.silent == Some(number) || crossings >= 3,
                "{what}: robot {number} has crossed {crossings} times: {:#?}",
                self.manager.status(self.now_ns())
            );
        }
    }
}

#[test]
fn a_net_serves_whichever_robots_come() {
    let mut crossing = Crossing::new();
    crossing.run(600);
    let crossings: Vec<u32> = { crossing.robots.iter() }
        .map(|robot| robot.crossings)
        .collect();
    // All come again and again, and the net lets one in at a time.
    let fewest = crossings.iter().min().copied().unwrap_or(0);
    assert!(fewest >= 5, "{crossings:?}");
    let status = crossing.manager.status(crossing.now_ns());
    assert_eq!(
        status.coordinations.iter().filter(|own| !own.over).count(),
        1
    );
}

/// Also where the net has it as one of its roles, and was about to let it in.
#[test]
fn a_robot_that_asks_and_is_heard_no_more_keeps_nobody_out() {
    let mut kept_nothing = 0;
    for robot in 0..ROBOTS {
        for later in 0..8 {
            let mut crossing = Crossing::new();
            crossing.run(100 + later);
            crossing.loses(robot);
            crossing.run(60);
            // Before it counted as silent it may have been let in: that it has until an operator sees that it is not there.
            let (now_ns, id) = (crossing.now_ns(), &crossing.setup.robots[robot].id);
            if crossing.holders().iter().any(|(holder, _)| holder == id) {
                assert!(crossing.manager.clear("Cr", false, now_ns).is_ok());
            } else {
                kept_nothing += 1;
            }
            crossing.assert_goes_on(400, "it is silent");
            // Its request stands: it is let in when it is heard again.
            crossing.silent = None;
            crossing.assert_goes_on(400, "it is back");
        }
    }
    assert!(kept_nothing >= ROBOTS, "{kept_nothing}");
}

#[test]
fn nor_does_it_after_a_restart() {
    for robot in 0..ROBOTS {
        let mut crossing = Crossing::new();
        crossing.run(100 + robot as u64);
        crossing.loses(robot);
        crossing.restart();
        crossing.run(60);
        let (id, now_ns) = (crossing.setup.robots[robot].id.clone(), crossing.now_ns());
        assert_eq!(crossing.manager.status(now_ns).awaited, [id.as_str()]);
        let room = format!("room-{robot}");
        assert_eq!(crossing.manager.absent(&id, true, now_ns), Ok(vec![room]));
        assert!(!crossing.waits(robot), "who is nowhere asks for nothing");
        crossing.assert_goes_on(400, "it is absent");
        crossing.silent = None;
        crossing.assert_goes_on(400, "it is back");
    }
}

/// What it was granted it has, silent or not, until somebody has looked.
#[test]
fn a_robot_that_was_let_in_and_is_heard_no_more_keeps_the_crossing() {
    for entered in [false, true] {
        let mut crossing = Crossing::new();
        crossing.run(100);
        let let_in = |own: &Crossing| {
            let mut robots = own.robots.iter();
            robots.position(|robot| robot.client.holds("Cr") && robot.inside == entered)
        };
        let robot = loop {
            crossing.go_on();
            if let Some(robot) = let_in(&crossing) {
                break robot;
            }
        };
        crossing.silent = Some(robot);
        let held = crossing.holders();
        assert_eq!(held[0].0, crossing.setup.robots[robot].id);
        let before = crossing.robots.iter().map(|own| own.crossings).sum::<u32>();
        crossing.run(200);
        assert_eq!(crossing.holders(), held);
        let after = crossing.robots.iter().map(|own| own.crossings).sum::<u32>();
        assert_eq!(before, after, "nobody else has been there");
        let now_ns = crossing.now_ns();
        assert!(crossing.manager.clear("Cr", true, now_ns).is_ok());
        crossing.robots[robot].inside = false;
        crossing.assert_goes_on(400, "it is carried away");
    }
}
