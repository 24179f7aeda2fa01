//! An operator closes an area and opens it again, while robots want into it, are granted it, and are in it.

use std::time::Duration;

use contract::client::{Client, Situation};
use contract::floor::Floor;
use contract::wire::Factsheet;
use mediator::journal::{ClosedRecord, Entry, Stored};
use mediator::manager::Manager;
use mediator::setup::{AreaSetup, RobotSetup, Setup};

const SECOND_NS: u64 = 1_000_000_000;

fn setup() -> Setup {
    let robot = |id: &str| RobotSetup {
        id: id.into(),
        role: "normal".into(),
        priority: 0,
        ages_after: 0,
        starts_in: Vec::new(),
    };
    let area = |id: &str| AreaSetup {
        id: id.into(),
        capacity: 2,
    };
    Setup {
        site: "hall".into(),
        areas: ["a", "b"].map(area).into(),
        robots: ["amr-1", "amr-2"].map(robot).into(),
        floor: Floor::default(),
        silent_after: Duration::from_secs(1),
    }
}

struct Bench {
    manager: Manager,
    stored: Stored,
    robots: Vec<(Client, Situation)>,
    now_ns: u64,
}

impl Bench {
    fn new() -> Self {
        let robot = |id: &str| {
            let situation = Situation {
                located: true,
                ..Situation::default()
            };
            let kind = Factsheet {
                manufacturer: "ours".into(),
                model: format!("model of {id}"),
                front_m: 0.3,
                left_m: 0.4,
                max_speed_m_s: 1.2,
                ..Factsheet::default()
            };
            (Client::new(id, "hall", 5).of_kind(kind), situation)
        };
        let stored = Stored::new(1);
        let mut bench = Self {
            manager: Manager::new(&setup(), &stored, 0).expect("a good setup"),
            stored,
            robots: ["amr-1", "amr-2"].map(robot).into(),
            // No robot may still enter what an earlier manager has granted.
            now_ns: 10 * SECOND_NS,
        };
        bench.talk();
        bench
    }

    /// Both sides talk until nobody has news.
    fn talk(&mut self) {
        for _ in 0..8 {
            self.now_ns += SECOND_NS / 10;
            for (client, situation) in &mut self.robots {
                client.step(situation.clone(), self.now_ns, SECOND_NS);
                self.manager.report(&client.report(), self.now_ns);
            }
            self.manager.tick(self.now_ns);
            while let Some(message) = self.manager.next_message(self.now_ns) {
                for (client, _) in &mut self.robots {
                    client.receive(&message, self.now_ns);
                }
            }
            self.write();
        }
    }

    fn write(&mut self) {
        let entries: Vec<Entry> = self.manager.entries().collect();
        entries
            .into_iter()
            .for_each(|entry| self.stored.apply(entry));
    }

    fn wants(&mut self, robot: usize, areas: &[&str]) {
        self.robots[robot].1.wanted = areas.iter().map(|&area| area.to_owned()).collect();
        self.talk();
    }

    fn stands_in(&mut self, robot: usize, areas: &[&str]) {
        self.robots[robot].1.stands_in = areas.iter().map(|&area| area.to_owned()).collect();
        self.talk();
    }

    fn status(&self) -> String {
        format!("{:#?}", self.manager.status(self.now_ns))
    }

    fn holds(&self, robot: usize, area: &str) -> bool {
        self.robots[robot].0.holds(area)
    }

    fn close(&mut self, area: &str) -> mediator::manager::Inside {
        let record = ClosedRecord {
            at: "2026-01-01T12:00:00Z".into(),
            who: "operator anna".into(),
            why: "wet floor".into(),
        };
        let inside = self.manager.close(area, record, self.now_ns);
        let inside = inside.expect("the site has it");
        self.talk();
        inside
    }

    fn open(&mut self, area: &str) -> bool {
        let was_closed = self.manager.open(area, self.now_ns);
        self.talk();
        was_closed.expect("the site has it")
    }
}

#[test]
fn nobody_is_let_into_a_closed_area_until_it_is_open_again() {
    let mut bench = Bench::new();
    assert_eq!(bench.close("a"), mediator::manager::Inside::default());
    bench.wants(0, &["a"]);
    bench.wants(1, &["a", "b"]);
    assert!(
        !bench.holds(0, "a") && !bench.holds(1, "a") && bench.holds(1, "b"),
        "{}",
        bench.status()
    );
    let why = bench.manager.why("amr-1", bench.now_ns).expect("a robot");
    assert!(
        why.contains("it is closed, by operator anna at 2026-01-01T12:00:00Z: wet floor"),
        "{why}"
    );
    let status = bench.manager.status(bench.now_ns);
    assert!(status.areas[0].closed && !status.areas[1].closed);
    assert!(bench.open("a"));
    assert!(bench.holds(0, "a") && bench.holds(1, "a"));
    assert!(!bench.open("a"), "it was open");
    assert!(bench.manager.open("c", 0).is_err());
}

#[test]
fn a_grant_that_is_not_used_yet_is_asked_back_and_who_is_inside_may_leave() {
    let mut bench = Bench::new();
    bench.wants(0, &["a"]);
    bench.stands_in(0, &["a"]);
    bench.wants(1, &["a"]);
    assert!(
        bench.holds(0, "a") && bench.holds(1, "a"),
        "{}",
        bench.status()
    );
    let inside = bench.close("a");
    assert_eq!(inside.standing, ["amr-1"]);
    assert_eq!(inside.granted, ["amr-2"]);
    assert!(bench.holds(0, "a"), "it is in it");
    assert!(!bench.holds(1, "a"), "it has given it back");
    bench.wants(0, &[]);
    bench.stands_in(0, &[]);
    assert!(!bench.holds(0, "a"), "it has left");
    bench.wants(0, &["a"]);
    assert!(!bench.holds(0, "a"), "and does not come back");
}

/// As in a turn, of which a corner reaches out of the area for a while.
#[test]
fn who_has_left_and_would_come_back_stays_out_of_a_closed_area() {
    let mut bench = Bench::new();
    bench.wants(0, &["a"]);
    bench.stands_in(0, &["a"]);
    bench.stands_in(0, &[]);
    assert!(bench.holds(0, "a"), "it is to come back");
    let inside = bench.close("a");
    assert!(inside.standing.is_empty(), "{inside:?}");
    assert_eq!(inside.granted, ["amr-1"]);
    assert!(!bench.holds(0, "a"), "it has given it back");
    bench.open("a");
    assert!(bench.holds(0, "a"));
}

#[test]
fn an_area_stays_closed_when_the_mediator_starts_again() {
    let mut bench = Bench::new();
    bench.wants(0, &["a"]);
    bench.stands_in(0, &["a"]);
    bench.close("a");
    bench.manager = Manager::new(&setup(), &bench.stored, bench.now_ns).expect("a good journal");
    bench.talk();
    bench.wants(1, &["a"]);
    assert!(bench.holds(0, "a") && !bench.holds(1, "a"));
    assert!(bench.open("a"));
    assert!(bench.holds(1, "a"));
    bench.manager = Manager::new(&setup(), &bench.stored, bench.now_ns).expect("a good journal");
    bench.talk();
    assert!(!bench.manager.status(bench.now_ns).areas[0].closed);
}

#[test]
fn a_robot_that_waits_hears_its_place_in_the_order() {
    let mut bench = Bench::new();
    bench.close("a");
    bench.wants(1, &["a"]);
    bench.wants(0, &["a", "b"]);
    bench.now_ns += SECOND_NS;
    bench.manager.tick(bench.now_ns);
    let mut places = Vec::new();
    while let Some(message) = bench.manager.next_message(bench.now_ns) {
        let places_of = message
            .access
            .iter()
            .map(|grant| (grant.area.clone(), grant.place));
        places.push((message.robot_id, places_of.collect::<Vec<_>>()));
    }
    places.sort();
    let place = |area: &str, place| (area.to_owned(), place);
    assert_eq!(places[0].1, [place("a", 2), place("b", 0)]);
    assert_eq!(places[1].1, [place("a", 1)]);
}

#[test]
fn what_kind_of_robot_it_is_outlasts_a_restart_of_the_mediator() {
    let mut bench = Bench::new();
    let model = |bench: &Bench| {
        let status = bench.manager.status(bench.now_ns);
        status.robots[1]
            .factsheet
            .as_ref()
            .map(|own| own.model.clone())
    };
    assert_eq!(model(&bench).as_deref(), Some("model of amr-2"));
    let status = bench.manager.status(bench.now_ns);
    let protocols =
        { status.robots.iter() }.map(|own| own.factsheet.clone().map(|own| own.protocols));
    assert!(protocols.eq([Some(vec![1, 2]), Some(vec![1, 2])]));
    assert_eq!(bench.manager.alarms().count(), 0, "none is too large");
    bench.manager = Manager::new(&setup(), &bench.stored, bench.now_ns).expect("a good journal");
    assert_eq!(model(&bench), None);
    // They follow it when the one before was not heard for a second.
    (0..3).for_each(|_| bench.talk());
    assert_eq!(model(&bench).as_deref(), Some("model of amr-2"));
}
