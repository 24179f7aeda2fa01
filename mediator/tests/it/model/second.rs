//! A second process with the identity of a robot: it believes to stand somewhere, asks for areas, and must get none.

use contract::client::{Client, Situation};
use contract::wire::{MediatorReport, RobotReport};

use super::floor::{Floor, SILENT_NS};
use crate::random::Random;

const REPORT_MS: u64 = 200;

pub struct Second {
    pub robot: usize,
    pub client: Client,
    situation: Situation,
    until_ms: u64,
    report_ms: u64,
}

impl Second {
    /// It runs for some seconds.
    pub fn start(robot: usize, id: &str, floor: &Floor, now_ms: u64, random: &mut Random) -> Self {
        let mut area = || floor.name(random.below(floor.limits.len() as u64) as usize);
        let [here, there] = [area(), area()].map(str::to_owned);
        let situation = Situation {
            located: true,
            stands_in: vec![here.clone()],
            wanted: vec![here, there],
            ..Situation::default()
        };
        Self {
            robot,
            client: Client::new(id, &floor.setup.site, random.next() | 1)
                .on(floor.setup.floor.clone()),
            situation,
            until_ms: now_ms + random.below(8_000),
            report_ms: 0,
        }
    }

    pub fn is_over(&self, now_ms: u64) -> bool {
        now_ms >= self.until_ms
    }

    pub fn receive(&mut self, message: &MediatorReport, now_ms: u64) {
        self.client.receive(message, now_ms * 1_000_000);
    }

    pub fn step(&mut self, now_ms: u64) -> Option<RobotReport> {
        let news = self
            .client
            .step(self.situation.clone(), now_ms * 1_000_000, SILENT_NS);
        let due = news || now_ms >= self.report_ms + REPORT_MS;
        due.then(|| {
            self.report_ms = now_ms;
            self.client.report()
        })
    }

    /// Nothing is granted to it, nor inherited by it.
    pub fn assert_has_nothing(&self, floor: &Floor) {
        assert!(!self.client.is_registered());
        for area in 0..floor.limits.len() {
            let name = floor.name(area);
            assert!(!self.client.holds(name), "the second process has {name}");
        }
    }
}
