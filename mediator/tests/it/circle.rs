//! Robots that wait for each other.

use std::time::Duration;

use contract::client::{Client, Situation};
use contract::floor::Floor;
use contract::timing::SILENT_AFTER_NS;
use mediator::journal::Stored;
use mediator::manager::Manager;
use mediator::setup::{AreaSetup, RobotSetup, Setup};

const AREAS: [&str; 4] = ["a", "b", "c", "d"];
const STEP_NS: u64 = 200_000_000;

/// Four areas of this capacity, with a robot of each of these priorities in one.
fn setup(priorities: [u32; 4], capacity: u32) -> Setup {
    let robots = (1..).zip(priorities).map(|(number, priority)| RobotSetup {
        id: format!("amr-{number}"),
        role: "normal".to_owned(),
        priority,
        ages_after: 0,
        starts_in: Vec::new(),
    });
    let area = |id: &str| AreaSetup {
        id: id.to_owned(),
        capacity,
    };
    Setup {
        site: "hall".to_owned(),
        areas: AREAS.map(area).to_vec(),
        robots: robots.collect(),
        floor: Floor::default(),
        silent_after: Duration::from_nanos(SILENT_AFTER_NS),
    }
}

struct Bench {
    manager: Manager,
    robots: Vec<Client>,
    /// What each wants besides where it stands.
    wants: [Option<&'static str>; 4],
    /// Whether it stands in its area.
    stands: [bool; 4],
    /// Whether the second one wants area `a` besides.
    also_wants_a: bool,
    now_ns: u64,
}

impl Bench {
    fn new(setup: &Setup) -> Self {
        let stored = Stored::new(1);
        let manager = Manager::new(setup, &stored, 0).expect("valid");
        let robots = { setup.robots.iter() }.map(|robot| Client::new(&robot.id, "hall", 7));
        Self {
            manager: manager.speaks_as(5),
            robots: robots.collect(),
            wants: [None; 4],
            stands: [true; 4],
            also_wants_a: false,
            now_ns: 0,
        }
    }

    /// Lets time pass; gives the alarms about circles.
    fn pass(&mut self, seconds: u64) -> Vec<String> {
        let mut alarms = Vec::new();
        for _ in 0..seconds * 5 {
            self.now_ns += STEP_NS;
            for (number, client) in self.robots.iter_mut().enumerate() {
                let here = Some(AREAS[number]).filter(|_| self.stands[number]);
                let besides = Some("a").filter(|_| number == 1 && self.also_wants_a);
                let wanted = [here, self.wants[number], besides].into_iter().flatten();
                let situation = Situation {
                    located: true,
                    stands_in: here.map(str::to_owned).into_iter().collect(),
                    wanted: wanted.map(str::to_owned).collect(),
                    ..Situation::default()
                };
                client.step(situation, self.now_ns, SILENT_AFTER_NS);
                self.manager.report(&client.report(), self.now_ns);
            }
            self.manager.tick(self.now_ns);
            while let Some(message) = self.manager.next_message(self.now_ns) {
                for client in &mut self.robots {
                    client.receive(&message, self.now_ns);
                }
            }
            let told = self.manager.alarms().map(|alarm| alarm.to_string());
            alarms.extend(told.filter(|line| line.contains("wait for each other")));
        }
        alarms
    }
}

#[test]
fn a_circle_is_told_once_with_who_is_to_back_out_of_what() {
    let mut bench = Bench::new(&setup([1, 0, 1, 0], 1));
    assert!(bench.pass(3).is_empty());
    bench.wants = [Some("b"), Some("c"), Some("a"), None];
    assert!(bench.pass(4).is_empty(), "it may be over soon");
    let alarms = bench.pass(20);
    assert_eq!(alarms.len(), 1, "{alarms:?}");
    let expected = [
        "amr-1 for area b, which amr-2 has; amr-2 for area c, which amr-3 has; amr-3 for area a, which amr-1 has",
        "pause `amr-2`, drive it out of area b",
    ];
    assert!(
        expected.iter().all(|part| alarms[0].contains(part)),
        "{alarms:?}"
    );
    // It does: the others go on.
    bench.stands[1] = false;
    assert!(bench.pass(20).is_empty());
    assert!(bench.robots[0].holds("b"));
}

/// Robots of these priorities wait for each other, of which the second one has an area that it is not in.
fn waits_and_is_elsewhere(priorities: [u32; 4]) -> Bench {
    let mut bench = Bench::new(&setup(priorities, 1));
    bench.stands[1] = false;
    bench.wants[1] = Some("b");
    bench.pass(8);
    let has = [bench.robots[0].holds("a"), bench.robots[1].holds("b")];
    assert_eq!(has, [true; 2]);
    bench.also_wants_a = true;
    bench.wants[0] = Some("b");
    bench
}

#[test]
fn an_area_that_nobody_of_a_circle_is_in_is_asked_back() {
    for priorities in [[0; 4], [1, 0, 0, 0]] {
        let mut bench = waits_and_is_elsewhere(priorities);
        assert!(bench.pass(20).is_empty(), "nobody need do anything");
        assert!(bench.robots[0].holds("b") && !bench.robots[1].holds("b"));
        assert_eq!(bench.robots[1].counters().yielded, 1);
        // It goes on, and leaves both.
        (bench.stands[0], bench.wants[0]) = (false, None);
        bench.pass(3);
        assert!(bench.robots[1].holds("a") && bench.robots[1].holds("b"));
    }
}

/// It would be let in again at once.
#[test]
fn of_a_more_important_robot_nothing_is_asked_back_and_people_are_told() {
    let mut bench = waits_and_is_elsewhere([0, 1, 0, 0]);
    assert_eq!(bench.pass(20).len(), 1);
    assert!(bench.robots[1].holds("b") && bench.robots[1].counters().yielded == 0);
}

#[test]
fn a_line_of_robots_and_areas_with_room_are_no_circle() {
    let mut line = Bench::new(&setup([0; 4], 1));
    line.wants = [Some("b"), Some("c"), None, None];
    assert!(line.pass(20).is_empty());
    let mut room = Bench::new(&setup([0; 4], 2));
    room.wants = [Some("b"), Some("c"), Some("a"), None];
    assert!(room.pass(20).is_empty());
}

/// The two that wait for each other are told, not the one that waits for them.
#[test]
fn who_waits_for_a_circle_is_not_of_it() {
    let mut bench = Bench::new(&setup([0; 4], 1));
    bench.wants = [Some("b"), Some("c"), Some("b"), None];
    let alarms = bench.pass(20);
    assert_eq!(alarms.len(), 1, "{alarms:?}");
    assert!(!alarms[0].contains("amr-1"), "{alarms:?}");
}

#[test]
fn two_circles_are_told_each_once() {
    let mut bench = Bench::new(&setup([0; 4], 1));
    bench.pass(3);
    bench.wants = [Some("b"), Some("a"), None, None];
    let first = bench.pass(10);
    assert!(
        first.len() == 1 && first[0].contains("amr-1 for area b"),
        "{first:?}"
    );
    // The first one lasts.
    bench.wants[2..].copy_from_slice(&[Some("d"), Some("c")]);
    let second = bench.pass(20);
    assert!(
        second.len() == 1 && second[0].contains("amr-3 for area d"),
        "{second:?}"
    );
}
