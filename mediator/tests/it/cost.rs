//! What a report costs does not grow with the fleet: counted, not timed.

use std::sync::Arc;

use contract::client::{Client, Situation};
use contract::timing::{ENTERS_NO_MORE_NS, LEVEL_PERIOD_NS, SILENT_AFTER_NS};
use mediator::journal::Stored;
use mediator::manager::Manager;
use mediator::nets::Plan;
use mediator::setup::Setup;

use crate::sites;

const REPORTS: u64 = 50;
/// Nets that wait for a situation that does not come.
const NETS: usize = 50;
const STEP_NS: u64 = 1_000_000;

struct Fleet {
    manager: Manager,
    robots: Vec<Client>,
    now_ns: u64,
}

impl Fleet {
    /// All stand in a hall.
    fn new((setup, plans): (Setup, Vec<Arc<Plan>>)) -> Self {
        let stored = Stored::new(1);
        let manager = Manager::with_plans(&setup, plans, &stored, 0).expect("valid");
        let client = |id: &String| Client::new(id, &setup.site, 7).on(setup.floor.clone());
        let ids: Vec<String> = setup.robots.iter().map(|own| own.id.clone()).collect();
        let mut fleet = Self {
            manager: manager.speaks_as(5),
            robots: ids.iter().map(client).collect(),
            now_ns: ENTERS_NO_MORE_NS,
        };
        for _ in 0..4 {
            (0..fleet.robots.len()).for_each(|robot| fleet.report(robot));
            fleet.manager.tick(fleet.now_ns);
            fleet.hear();
        }
        assert!(fleet.manager.status(fleet.now_ns).awaited.is_empty());
        fleet
    }

    fn report(&mut self, robot: usize) {
        self.ask(robot, &[]);
    }

    /// A report of a robot that wants to be in these areas.
    fn ask(&mut self, robot: usize, areas: &[&str]) {
        let situation = Situation {
            located: true,
            stands_in: vec!["hall".to_owned()],
            wanted: areas.iter().map(|&area| area.to_owned()).collect(),
            ..Situation::default()
        };
        let client = &mut self.robots[robot];
        client.step(situation, self.now_ns, SILENT_AFTER_NS);
        self.manager.report(&client.report(), self.now_ns);
    }

    fn hear(&mut self) {
        while let Some(message) = self.manager.next_message(self.now_ns) {
            let robot: usize = message.robot_id["amr-".len()..].parse().expect("a number");
            self.robots[robot].receive(&message, self.now_ns);
        }
    }

    /// Robots looked at for each of some reports, with no tick between them.
    fn looks(&mut self) -> u64 {
        let before = self.manager.counters();
        for number in 0..REPORTS as usize {
            self.now_ns += STEP_NS;
            self.report(number);
        }
        let after = self.manager.counters();
        assert_eq!(after.reports - before.reports, REPORTS);
        (after.looks - before.looks) / REPORTS
    }
}

#[test]
fn a_report_costs_the_same_in_a_large_fleet() {
    let [small, large] = [100, 1000].map(|robots| Fleet::new(sites::idle(robots, NETS)).looks());
    assert_eq!(small, large);
    // Whom it follows, and the one role of each net.
    assert!((NETS as u64..2 * NETS as u64).contains(&small), "{small}");
}

#[test]
fn levels_of_a_large_fleet_are_repeated_few_at_a_time_and_none_too_late() {
    const ROBOTS: usize = 1000;
    const LOOK_NS: u64 = 2_000_000;
    let mut fleet = Fleet::new(sites::idle(ROBOTS, 1));
    fleet.hear();
    // All have heard at the same time, the worst case.
    let told_ns = fleet.now_ns;
    let mut heard = vec![0; ROBOTS];
    while fleet.now_ns < told_ns + 2 * LEVEL_PERIOD_NS {
        fleet.now_ns += LOOK_NS;
        fleet.manager.repeat_levels(fleet.now_ns);
        let mut together = 0;
        while let Some(message) = fleet.manager.next_message(fleet.now_ns) {
            let robot: usize = message.robot_id["amr-".len()..].parse().expect("a number");
            heard[robot] += 1;
            together += 1;
        }
        assert!(together <= 16, "{together} at once");
    }
    assert!(heard.iter().all(|&times| times >= 1), "{heard:?}");
}

#[test]
fn what_runs_goes_on_when_there_is_news_for_it_and_not_with_each_report() {
    let mut fleet = Fleet::new(sites::crossings(100, NETS));
    let status = fleet.manager.status(fleet.now_ns);
    assert_eq!(
        status.coordinations.iter().filter(|own| !own.over).count(),
        NETS
    );
    fleet.hear();
    // These play no role, until they ask for a crossing.
    let bystanders = 10..10 + REPORTS as usize;
    bystanders.clone().for_each(|robot| fleet.report(robot));
    let before = fleet.manager.counters();
    for robot in bystanders.clone() {
        fleet.now_ns += STEP_NS;
        fleet.report(robot);
    }
    let after = fleet.manager.counters();
    assert_eq!(
        (after.reports - before.reports, after.steps),
        (REPORTS, before.steps)
    );
    // One that asks is let in at once. The three that play there play in all other nets too, which look at them once.
    let (robot, area) = (bystanders.start, "Cr-7");
    for _ in 0..3 {
        fleet.now_ns += STEP_NS;
        fleet.ask(robot, &["hall", area]);
        fleet.hear();
    }
    assert!(fleet.robots[robot].holds(area));
    let steps = fleet.manager.counters().steps - before.steps;
    assert!((1..2 * NETS as u64).contains(&steps), "{steps}");
}

/// A site opens, and all want the same area.
#[test]
fn why_a_robot_waits_is_told_in_a_sentence_however_many_wait() {
    let mut fleet = Fleet::new(sites::idle(1000, 1));
    let area = fleet.manager.status(fleet.now_ns).areas[1].id.clone();
    fleet.now_ns += STEP_NS;
    for robot in 0..fleet.robots.len() {
        fleet.ask(robot, &["hall", &area]);
    }
    fleet.now_ns += 2 * LEVEL_PERIOD_NS;
    fleet.manager.repeat_levels(fleet.now_ns);
    let mut told = 0;
    while let Some(message) = fleet.manager.next_message(fleet.now_ns) {
        for own in &message.access {
            let text = &own.waits_for;
            assert!(text.len() < 1000, "{} bytes: {text}", text.len());
            told += usize::from(text.contains("and ") && text.contains(" more"));
        }
    }
    assert!(told > 0);
}
