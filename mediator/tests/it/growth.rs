//! What messages carry of areas that nobody uses any more.

use std::time::Duration;

use contract::client::{Client, Situation};
use contract::floor::Floor;
use contract::timing::SILENT_AFTER_NS;
use contract::wire::{MediatorReport, RobotReport};
use mediator::journal::Stored;
use mediator::manager::Manager;
use mediator::setup::{AreaSetup, RobotSetup, Setup};

use crate::random::Random;

const AREAS: usize = 50;
const ID: &str = "amr-1";
const STEP_NS: u64 = 100_000_000;

fn name(area: usize) -> String {
    format!("area-{area}")
}

fn robot(id: String) -> RobotSetup {
    RobotSetup {
        id,
        role: "normal".into(),
        priority: 0,
        ages_after: 0,
        starts_in: Vec::new(),
    }
}

fn setup() -> Setup {
    let area = |area| AreaSetup {
        id: name(area),
        capacity: 1,
    };
    Setup {
        site: "ring".into(),
        areas: (0..AREAS).map(area).collect(),
        robots: vec![robot(ID.into())],
        floor: Floor::default(),
        silent_after: Duration::from_secs(1),
    }
}

/// A robot that drives through all areas one after the other, and its mediator; messages may get lost.
struct Ring {
    manager: Manager,
    client: Client,
    random: Random,
    lost_percent: u64,
    at: usize,
    moves: u32,
    now_ns: u64,
    last: (RobotReport, MediatorReport),
}

impl Ring {
    fn new(lost_percent: u64, seed: u64) -> Self {
        let setup = setup();
        Self {
            manager: Manager::new(&setup, &Stored::new(1), 0).expect("valid"),
            client: Client::new(ID, &setup.site, 5),
            random: Random::new(seed),
            lost_percent,
            at: 0,
            moves: 0,
            now_ns: 0,
            last: Default::default(),
        }
    }

    fn step(&mut self) {
        self.now_ns += STEP_NS;
        let next = (self.at + 1) % AREAS;
        if self.client.holds(&name(next)) && self.client.has_lease(self.now_ns) {
            self.at = next;
            self.moves += 1;
        }
        let (at, next) = (name(self.at), name((self.at + 1) % AREAS));
        let situation = Situation {
            located: true,
            stands_in: vec![at.clone()],
            wanted: vec![at, next],
            ..Situation::default()
        };
        self.client.step(situation, self.now_ns, SILENT_AFTER_NS);
        self.last.0 = self.client.report();
        if !self.random.chance(self.lost_percent) {
            self.manager.report(&self.last.0, self.now_ns);
        }
        self.manager.tick(self.now_ns);
        while let Some(message) = self.manager.next_message(self.now_ns) {
            if !self.random.chance(self.lost_percent) {
                self.client.receive(&message, self.now_ns);
            }
            self.last.1 = message;
        }
    }

    /// How many areas the last messages of either side mention.
    fn mentioned(&self) -> [usize; 2] {
        [self.last.0.access.len(), self.last.1.access.len()]
    }
}

#[test]
fn messages_grow_with_what_is_open_and_not_with_what_ever_was() {
    for (lost_percent, most) in [(0, 5), (30, 12)] {
        let mut ring = Ring::new(lost_percent, 7);
        let (mut sum, mut steps) = (0, 0);
        while ring.moves < 3 * AREAS as u32 {
            ring.step();
            steps += 1;
            assert!(steps < 20_000, "it stands still after {} moves", ring.moves);
            if ring.moves > AREAS as u32 {
                let mentioned = ring.mentioned();
                assert!(
                    mentioned.iter().all(|&areas| areas <= most),
                    "{mentioned:?}"
                );
                sum += mentioned[0] + mentioned[1];
            }
        }
        assert!(sum > 0);
        assert_eq!(ring.manager.alarms().count(), 0);
    }
}

/// So that news need not wait behind a thousand of them.
#[test]
fn repetitions_are_spread_over_their_period() {
    const ROBOTS: usize = 1000;
    const TICK_NS: u64 = 20_000_000;
    let setup = Setup {
        robots: (0..ROBOTS)
            .map(|number| robot(format!("amr-{number}")))
            .collect(),
        ..setup()
    };
    let mut manager = Manager::new(&setup, &Stored::new(1), 0).expect("valid");
    let mut told = vec![0; ROBOTS];
    let number_of = |message: &MediatorReport| -> usize {
        message.robot_id[4..].parse().expect("as named above")
    };
    for (number, robot) in setup.robots.iter().enumerate() {
        // They come at the same time.
        let mut client = Client::new(&robot.id, &setup.site, 5 + number as u64);
        manager.report(&client.report(), 0);
        while let Some(message) = manager.next_message(0) {
            assert_eq!(number_of(&message), number);
            client.receive(&message, 0);
        }
        manager.report(&client.report(), 0);
    }
    while manager.next_message(0).is_some() {}
    for tick in 1..200 {
        let now_ns = tick * TICK_NS;
        manager.tick(now_ns);
        let mut messages = 0;
        while let Some(message) = manager.next_message(now_ns) {
            let gap_ns = now_ns - std::mem::replace(&mut told[number_of(&message)], now_ns);
            // At first they wait for their turn.
            let most_ns = if tick < 40 { 400_000_000 } else { 240_000_000 };
            assert!(gap_ns <= most_ns, "{gap_ns} ns at {now_ns} ns");
            messages += 1;
        }
        assert!(messages <= ROBOTS / 8 + 1, "{messages} at {now_ns} ns");
    }
    assert!(told.iter().all(|&at_ns| at_ns > 150 * TICK_NS));
}

#[test]
fn who_has_forgotten_hears_it_again() {
    for seed in 0..20 {
        let mut ring = Ring::new(20, seed);
        let mut steps = 0;
        while ring.moves < 2 * AREAS as u32 {
            ring.step();
            steps += 1;
            assert!(steps < 20_000, "it stands still after {} moves", ring.moves);
            if steps % 200 == 199 {
                ring.client = Client::new(ID, "ring", 5 + steps);
            }
        }
        let held: Vec<usize> = (0..AREAS)
            .filter(|&area| ring.client.holds(&name(area)))
            .collect();
        assert!(held.contains(&ring.at), "seed {seed}: {held:?}");
    }
}
