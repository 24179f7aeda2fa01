//! Robots on a ring of areas, one mediator, and the network between them.

use std::time::Duration;

use super::random::Random;
use contract::client::{Client, Situation};
use contract::wire::{MediatorReport, RobotReport};
use mediator::journal::Stored;
use mediator::manager::{Alarm, Manager};
use mediator::setup::{AreaSetup, RobotSetup, Setup};

const STEP_MS: u64 = 20;
const SILENT_NS: u64 = 1_000_000_000;
const REPORT_MS: u64 = 200;

#[derive(Clone, Copy, PartialEq, Eq)]
pub enum Faults {
    None,
    All,
}

/// A robot's body, which no crash moves, and the process in it.
struct Robot {
    id: String,
    /// It reaches into this area, and into the one after it while it crosses the border.
    area: usize,
    crossing: bool,
    /// Time at which the present motion ends.
    until_ms: u64,
    moves: u64,
    process: Option<Client>,
    /// When the process starts again.
    restart_ms: u64,
    report_ms: u64,
}

enum Message {
    ToMediator(RobotReport),
    ToRobot(MediatorReport),
}

pub struct Fleet {
    setup: Setup,
    capacities: Vec<u32>,
    robots: Vec<Robot>,
    manager: Option<Manager>,
    manager_restart_ms: u64,
    journal: Stored,
    network: Vec<(u64, Message)>,
    now_ms: u64,
    crashes: u64,
    alarms: Vec<String>,
}

impl Fleet {
    pub fn new(random: &mut Random) -> Self {
        let areas = 3 + random.below(6) as usize;
        let capacities: Vec<u32> = (0..areas).map(|_| 1 + random.below(2) as u32).collect();
        // Round a ring somebody can always move when not all of it is full.
        let most = capacities.iter().sum::<u32>() as usize - 1;
        let count = 1 + random.below(most.min(6) as u64) as usize;
        let mut free = capacities.clone();
        let mut robots = Vec::new();
        for number in 0..count {
            let area = loop {
                let area = random.below(areas as u64) as usize;
                if free[area] > 0 {
                    free[area] -= 1;
                    break area;
                }
            };
            robots.push(Robot {
                id: format!("r{number}"),
                area,
                crossing: false,
                until_ms: 0,
                moves: 0,
                process: None,
                restart_ms: random.below(500),
                report_ms: 0,
            });
        }
        let setup = Setup {
            site: "ring".into(),
            areas: capacities
                .iter()
                .enumerate()
                .map(|(number, &capacity)| AreaSetup {
                    id: format!("a{number}"),
                    capacity,
                })
                .collect(),
            robots: robots
                .iter()
                .map(|robot| RobotSetup {
                    id: robot.id.clone(),
                    role: "normal".into(),
                    priority: 0,
                    starts_in: vec![format!("a{}", robot.area)],
                })
                .collect(),
            silent_after: Duration::from_nanos(SILENT_NS),
        };
        Self {
            setup,
            capacities,
            robots,
            manager: None,
            manager_restart_ms: 0,
            journal: Stored::default(),
            network: Vec::new(),
            now_ms: 0,
            crashes: 0,
            alarms: Vec::new(),
        }
    }

    pub fn run(&mut self, for_ms: u64, faults: Faults, random: &mut Random, seed: u64) {
        let end_ms = self.now_ms + for_ms;
        while self.now_ms < end_ms {
            self.now_ms += STEP_MS;
            if faults == Faults::All {
                self.crash_somebody(random);
            }
            self.start_whoever_is_due(random);
            self.deliver(faults, random);
            self.drive(random);
            self.step_clients(faults, random);
            self.step_manager(None, faults, random);
            self.judge(seed);
        }
    }

    /// Whoever is down starts at once.
    pub fn recover(&mut self) {
        self.manager_restart_ms = self.now_ms;
        for robot in &mut self.robots {
            robot.restart_ms = self.now_ms;
        }
    }

    pub fn moves(&self) -> Vec<u64> {
        self.robots.iter().map(|robot| robot.moves).collect()
    }

    pub fn crashes(&self) -> u64 {
        self.crashes
    }

    pub fn explain(&self) -> String {
        let status = self
            .manager
            .as_ref()
            .map(|manager| manager.status(self.now_ms * 1_000_000));
        format!("{status:#?}\nalarms: {:#?}", self.alarms)
    }

    /// These robots keep the rules, so the mediator must never accuse one.
    pub fn assert_no_violation_was_claimed(&self, seed: u64) {
        assert!(self.alarms.is_empty(), "seed {seed}: {}", self.explain());
    }

    fn crash_somebody(&mut self, random: &mut Random) {
        for robot in &mut self.robots {
            if robot.process.is_some() && random.below(250) == 0 {
                robot.process = None;
                robot.restart_ms = self.now_ms + random.below(3_000);
                // The body stops where it is.
                robot.until_ms = u64::MAX;
                self.crashes += 1;
            }
        }
        if self.manager.is_some() && random.below(250) == 0 {
            self.crash_manager(random);
        }
    }

    fn crash_manager(&mut self, random: &mut Random) {
        self.manager = None;
        self.manager_restart_ms = self.now_ms + random.below(3_000);
        self.crashes += 1;
    }

    fn start_whoever_is_due(&mut self, random: &mut Random) {
        for robot in &mut self.robots {
            if robot.process.is_none() && self.now_ms >= robot.restart_ms {
                robot.process = Some(Client::new(&robot.id, "ring", random.next() | 1));
                robot.until_ms = self.now_ms + random.below(500);
            }
        }
        if self.manager.is_none() && self.now_ms >= self.manager_restart_ms {
            let manager = Manager::new(&self.setup, &self.journal, self.now_ms * 1_000_000);
            self.manager = Some(manager.expect("its own journal"));
        }
    }

    fn deliver(&mut self, faults: Faults, random: &mut Random) {
        let now_ms = self.now_ms;
        let (due, later): (Vec<_>, Vec<_>) = std::mem::take(&mut self.network)
            .into_iter()
            .partition(|(at_ms, _)| *at_ms <= now_ms);
        self.network = later;
        for (_, message) in due {
            match message {
                Message::ToMediator(report) => self.step_manager(Some(&report), faults, random),
                Message::ToRobot(message) => {
                    let robot = self
                        .robots
                        .iter_mut()
                        .find(|robot| robot.id == message.robot_id);
                    if let Some(client) = robot.and_then(|robot| robot.process.as_mut()) {
                        client.receive(&message, now_ms * 1_000_000);
                    }
                }
            }
        }
    }

    fn send(&mut self, message: impl Fn() -> Message, faults: Faults, random: &mut Random) {
        if faults == Faults::None {
            self.network.push((self.now_ms + STEP_MS, message()));
            return;
        }
        let copies = match random.below(10) {
            0..3 => 0,
            3 => 2,
            _ => 1,
        };
        for _ in 0..copies {
            let delay_ms = if random.chance(20) {
                random.below(2_000)
            } else {
                random.below(40)
            };
            self.network.push((self.now_ms + delay_ms, message()));
        }
    }

    /// Bodies move as long as their process wants; only areas that it holds are entered.
    fn drive(&mut self, random: &mut Random) {
        let areas = self.capacities.len();
        for robot in &mut self.robots {
            let Some(client) = &robot.process else {
                continue;
            };
            if robot.until_ms == u64::MAX || self.now_ms < robot.until_ms {
                continue;
            }
            let next = (robot.area + 1) % areas;
            if robot.crossing {
                robot.area = next;
                robot.crossing = false;
                robot.moves += 1;
                robot.until_ms = self.now_ms + 100 + random.below(400);
            } else if client.is_registered() && client.holds(&format!("a{next}")) {
                robot.crossing = true;
                robot.until_ms = self.now_ms + 50 + random.below(200);
            }
        }
    }

    fn step_clients(&mut self, faults: Faults, random: &mut Random) {
        let areas = self.capacities.len();
        let now_ms = self.now_ms;
        let mut reports = Vec::new();
        for robot in &mut self.robots {
            let name = |area: usize| format!("a{area}");
            let next = (robot.area + 1) % areas;
            let mut stands_in = vec![name(robot.area)];
            if robot.crossing {
                stands_in.push(name(next));
            }
            let Some(client) = &mut robot.process else {
                continue;
            };
            let situation = Situation {
                located: client.is_registered(),
                stands_in,
                wanted: vec![name(robot.area), name(next)],
                committed: Vec::new(),
                pose: None,
                fsm_state: name(robot.area),
            };
            let news = client.step(situation, now_ms * 1_000_000, SILENT_NS);
            if news || now_ms >= robot.report_ms + REPORT_MS {
                robot.report_ms = now_ms;
                reports.push(client.report());
            }
        }
        for report in reports {
            self.send(|| Message::ToMediator(report.clone()), faults, random);
        }
    }

    /// Hands the manager a report, or lets time pass; then journal, then network, with a crash at any point between.
    fn step_manager(&mut self, report: Option<&RobotReport>, faults: Faults, random: &mut Random) {
        let now_ns = self.now_ms * 1_000_000;
        let Some(manager) = &mut self.manager else {
            return;
        };
        match report {
            Some(report) => manager.report(report, now_ns),
            None => manager.tick(now_ns),
        }
        let entries: Vec<_> = manager.entries().collect();
        for alarm in manager.alarms() {
            let accuses = !matches!(alarm, Alarm::Silent { .. } | Alarm::Back { .. });
            if accuses {
                self.alarms.push(format!("{} ms: {alarm}", self.now_ms));
            }
        }
        let mut messages = Vec::new();
        while let Some(message) = manager.next_message(now_ns) {
            messages.push(message);
        }
        let crash = (faults == Faults::All && !entries.is_empty() && random.below(40) == 0)
            .then(|| random.below(3));
        if crash == Some(0) {
            // Before the journal: nobody hears of it.
            return self.crash_manager(random);
        }
        entries
            .into_iter()
            .for_each(|entry| self.journal.apply(entry));
        if crash == Some(1) {
            // After the journal, before the network.
            return self.crash_manager(random);
        }
        for message in messages {
            self.send(|| Message::ToRobot(message.clone()), faults, random);
        }
        if crash == Some(2) {
            self.crash_manager(random);
        }
    }

    /// By where the bodies are, not by what anybody says.
    fn judge(&self, seed: u64) {
        let areas = self.capacities.len();
        for (area, &capacity) in self.capacities.iter().enumerate() {
            let inside: Vec<&str> = self
                .robots
                .iter()
                .filter(|robot| {
                    robot.area == area || (robot.crossing && (robot.area + 1) % areas == area)
                })
                .map(|robot| robot.id.as_str())
                .collect();
            assert!(
                inside.len() <= capacity as usize,
                "seed {seed}, {} ms: area a{area} holds {capacity}, and {inside:?} are in it: {}",
                self.now_ms,
                self.explain()
            );
        }
    }
}
