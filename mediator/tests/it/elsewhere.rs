//! A new process of a robot that stands where the one before cannot have come to: the body before may still be where it was.

use contract::client::{Client, Situation};
use contract::timing::{ENTERS_NO_MORE_NS, SILENT_AFTER_NS};
use mediator::journal::Stored;
use mediator::manager::{Alarm, ClearError, Manager, Status};

use crate::takeover::{AREA, NOW_NS, cleared_of, robot, setup, start, talk};

const STEP_NS: u64 = SILENT_AFTER_NS / 5;
const OWN: &str = "amr-2";

/// A mediator and its journal, the robots that are heard, and the time.
struct Hall {
    manager: Manager,
    stored: Stored,
    robots: Vec<(Client, Situation)>,
    now_ns: u64,
}

fn stands_in(areas: &[&str]) -> Situation {
    let areas: Vec<String> = areas.iter().map(|&area| area.to_owned()).collect();
    Situation {
        located: true,
        wanted: areas.clone(),
        stands_in: areas,
        ..Situation::default()
    }
}

impl Hall {
    fn new() -> Self {
        let stored = Stored::new(1);
        let mut hall = Self {
            manager: start(&stored, 50, 0),
            stored,
            robots: ["amr-1", OWN, "amr-3"].map(|id| robot(id, &[])).into(),
            now_ns: NOW_NS,
        };
        hall.goes_on(2);
        hall
    }

    /// The second robot was let into these areas, and stands in some of them when it is heard last. Returns its process.
    fn asleep(has: &[&str], inside: &[&str]) -> (Self, Client) {
        let mut hall = Self::new();
        hall.robots[1].1 = stands_in(has);
        hall.robots[1].1.stands_in.clear();
        hall.goes_on(2);
        hall.robots[1].1.stands_in = stands_in(inside).stands_in;
        hall.goes_on(2);
        assert!(has.iter().all(|area| hall.robots[1].0.holds(area)));
        let (process, _) = hall.robots.remove(1);
        hall.goes_on(10);
        (hall, process)
    }

    fn goes_on(&mut self, rounds: usize) -> Status {
        for _ in 0..rounds {
            self.now_ns += STEP_NS;
            talk(&mut self.manager, &mut self.robots, self.now_ns);
            (self.manager.entries()).for_each(|entry| self.stored.apply(entry));
        }
        self.manager.status(self.now_ns)
    }

    /// Another process of it is switched on, and taken in. Returns where the mediator takes others of its name to stand.
    fn switched_on(&mut self, boot_epoch: u64, there: Situation) -> Vec<String> {
        let client = Client::new(OWN, "hall", boot_epoch);
        self.robots.push((client, there));
        let status = self.goes_on(40);
        let (client, _) = self.robots.last().expect("it was pushed");
        assert!(client.is_registered(), "{status:?}");
        status.robots[1].second_in.clone()
    }

    /// What people were told since they were last.
    fn told(&mut self) -> Vec<Alarm> {
        let told = self.manager.alarms();
        told.filter(|own| !matches!(own, Alarm::Silent { .. }))
            .collect()
    }

    /// The first robot asks for the gate. Returns whether it gets it.
    fn lets_in(&mut self) -> bool {
        self.robots[0].1.wanted = vec![AREA.to_owned()];
        self.goes_on(10);
        self.robots[0].0.holds(AREA)
    }

    fn starts_again(&mut self) {
        let instance = self.manager.instance() + 1;
        self.manager = start(&self.stored, instance, self.now_ns);
    }
}

fn elsewhere(here: &str, areas: &str) -> Alarm {
    Alarm::StartedElsewhere {
        robot: OWN.to_owned(),
        here: here.to_owned(),
        areas: areas.to_owned(),
    }
}

/// Its computer sleeps, and a copy of it is switched on elsewhere.
#[test]
fn where_the_one_before_was_nobody_is_let_in_until_it_says_that_it_is_elsewhere() {
    for place in [&["yard"][..], &[]] {
        let (mut hall, sleeper) = Hall::asleep(&[AREA], &[AREA]);
        assert_eq!(hall.switched_on(8, stands_in(place)), [AREA]);
        let here = if place.is_empty() {
            "no area"
        } else {
            "area yard"
        };
        assert_eq!(hall.told(), [elsewhere(here, AREA)]);
        assert_eq!(hall.manager.counters().elsewhere, 1);
        assert!(!hall.lets_in() && hall.told().is_empty(), "told once");
        let why = hall.manager.why("amr-1", hall.now_ns).expect("a robot");
        assert!(why.contains("mediator clear gate --taken-away"), "{why}");
        // Also with the next mediator.
        hall.starts_again();
        hall.goes_on(60);
        assert!(!hall.lets_in());
        let status = hall.goes_on(1);
        assert!(status.awaited.is_empty() && status.robots[1].second_in == [AREA]);
        // It wakes up, and is heard where it was.
        hall.robots.push((sleeper, stands_in(&[AREA])));
        assert!(!hall.lets_in());
        assert!(matches!(
            hall.manager.clear(AREA, true, hall.now_ns),
            Err(ClearError::Heard { .. })
        ));
        let sleeper = hall.robots.last_mut().expect("it was pushed");
        assert!(!sleeper.0.is_registered() && !sleeper.0.holds(AREA));
        sleeper.1 = stands_in(&[]);
        assert!(hall.lets_in());
    }
}

#[test]
fn where_the_one_before_was_people_clear() {
    let (mut hall, _) = Hall::asleep(&[AREA], &[AREA]);
    assert_eq!(hall.switched_on(8, stands_in(&["yard"])), [AREA]);
    let inside = hall.manager.clear(AREA, false, hall.now_ns);
    assert!(
        matches!(inside, Err(ClearError::Inside { .. })),
        "{inside:?}"
    );
    let cleared = hall.manager.clear(AREA, true, hall.now_ns);
    assert_eq!(cleared, cleared_of("a second process of amr-2"));
    assert!(hall.lets_in());
}

/// The mediator has started since, and knows it from its journal alone.
#[test]
fn where_the_one_before_was_the_journal_knows() {
    let (mut hall, _) = Hall::asleep(&[AREA], &[AREA]);
    hall.starts_again();
    assert_eq!(hall.switched_on(8, stands_in(&["yard"])), [AREA]);
    assert_eq!(hall.told(), [elsewhere("area yard", AREA)]);
    assert!(!hall.lets_in());
}

/// What it had it may have entered before it was silent for too long.
#[test]
fn what_the_one_before_had_counts_as_well() {
    for inside in [&["yard"][..], &[]] {
        let (mut hall, _) = Hall::asleep(&[AREA, "yard"], inside);
        let blocked = hall.switched_on(8, stands_in(&[]));
        // Beside all areas, as before: one that stands before a border starts anew there.
        let is_beside = inside.is_empty();
        if is_beside {
            assert!(blocked.is_empty() && hall.told().is_empty());
        } else {
            assert_eq!(blocked, [AREA, "yard"]);
            assert_eq!(hall.told(), [elsewhere("no area", "gate, yard")]);
        }
        assert_eq!(hall.lets_in(), is_beside);
    }
    // It had one then, and is in another one.
    let (mut hall, _) = Hall::asleep(&[AREA], &[]);
    assert_eq!(hall.switched_on(8, stands_in(&["yard"])), [AREA]);
    assert!(!hall.lets_in());
}

/// Where it stood, and where it drove on to by what it had.
#[test]
fn a_robot_that_starts_anew_where_it_was_or_had_an_area_goes_on() {
    for there in [&[AREA][..], &["yard"], &[AREA, "yard"]] {
        let (mut hall, _) = Hall::asleep(&[AREA, "yard"], &[AREA]);
        let blocked = hall.switched_on(8, stands_in(there));
        assert!(blocked.is_empty() && hall.told().is_empty(), "{there:?}");
        assert_eq!(hall.manager.counters().elsewhere, 0);
        let (client, situation) = hall.robots.last_mut().expect("it was pushed");
        assert!(there.iter().all(|area| client.holds(area)));
        *situation = stands_in(&[]);
        assert!(hall.lets_in(), "{there:?}");
    }
}

/// An operator said that it is gone.
#[test]
fn a_robot_that_was_absent_starts_anew_wherever_it_is_brought() {
    for restarts in [false, true] {
        let (mut hall, _) = Hall::asleep(&[AREA], &[AREA]);
        hall.now_ns += ENTERS_NO_MORE_NS;
        hall.goes_on(1);
        let absent = hall.manager.absent(OWN, true, hall.now_ns);
        assert_eq!(absent, Ok(vec![AREA.to_owned()]));
        hall.goes_on(1);
        if restarts {
            hall.starts_again();
        }
        assert!(hall.switched_on(8, stands_in(&["yard"])).is_empty());
        let told = hall.told();
        let is_blocked = |own: &Alarm| matches!(own, Alarm::StartedElsewhere { .. });
        assert!(!told.iter().any(is_blocked), "{told:?}");
        assert!(hall.lets_in());
    }
}

/// It finds its place later, when the mediator has started again, or a process after it does.
#[test]
fn a_robot_that_does_not_know_where_it_is_keeps_what_it_had_until_it_does() {
    for (restarts, dies, there) in [
        (false, false, AREA),
        (false, false, "yard"),
        (true, false, AREA),
        (true, false, "yard"),
        (true, true, AREA),
        (true, true, "yard"),
    ] {
        let (mut hall, _) = Hall::asleep(&[AREA], &[AREA]);
        let lost = Situation::default();
        assert!(hall.switched_on(8, lost).is_empty());
        assert!(!hall.lets_in() && hall.told().is_empty());
        if restarts {
            hall.starts_again();
        }
        if dies {
            hall.robots.pop();
            hall.goes_on(40);
            hall.switched_on(9, stands_in(&[there]));
        } else {
            hall.robots.last_mut().expect("it was pushed").1 = stands_in(&[there]);
        }
        let status = hall.goes_on(60);
        assert!(status.awaited.is_empty(), "{status:?}");
        assert!(!hall.lets_in());
        let second_in = hall.goes_on(1).robots.remove(1).second_in;
        let told = hall.told();
        if there == AREA {
            assert!(second_in.is_empty() && told.is_empty(), "{told:?}");
        } else {
            assert_eq!(second_in, [AREA]);
            assert_eq!(told, [elsewhere("area yard", AREA)]);
        }
    }
}

/// It counts as one body.
#[test]
fn in_an_area_for_two_there_is_room_for_one_more() {
    let mut two = setup();
    two.areas[0].capacity = 2;
    let mut hall = Hall::new();
    hall.manager = Manager::new(&two, &hall.stored, hall.now_ns).expect("valid");
    hall.goes_on(30);
    hall.robots[1].1 = stands_in(&[AREA]);
    hall.goes_on(3);
    hall.robots.remove(1);
    hall.goes_on(10);
    assert_eq!(hall.switched_on(8, stands_in(&["yard"])), [AREA]);
    assert!(hall.lets_in());
    hall.robots[1].1.wanted = vec![AREA.to_owned()];
    hall.goes_on(10);
    assert!(!hall.robots[1].0.holds(AREA), "two are in it");
}

/// The process before is heard again before the new one was taken in.
#[test]
fn one_that_was_only_out_of_reach_goes_on() {
    let (mut hall, first) = Hall::asleep(&[AREA], &[AREA]);
    let (mut other, there) = (Client::new(OWN, "hall", 8), stands_in(&["yard"]));
    other.step(there, hall.now_ns, SILENT_AFTER_NS);
    hall.manager.report(&other.report(), hall.now_ns);
    hall.robots.push((first, stands_in(&[AREA])));
    let later = (ENTERS_NO_MORE_NS / STEP_NS) as usize;
    let status = hall.goes_on(later);
    assert!(status.robots[1].heard && status.robots[1].second_in.is_empty());
    let (first, situation) = hall.robots.last_mut().expect("it was pushed");
    assert!(first.holds(AREA));
    *situation = stands_in(&[]);
    assert!(hall.lets_in());
}
