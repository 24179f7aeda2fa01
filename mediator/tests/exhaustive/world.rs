//! All parties, the network between them, and what may still go wrong.

use std::collections::hash_map::DefaultHasher;
use std::hash::{Hash, Hasher};

use contract::wire::{MediatorReport, RobotReport};
use mediator::journal::Stored;
use mediator::manager::Manager;

use super::action::{AREAS, Fate};
use super::kept::Kept;
use super::office::manager;
use super::robot::Robot;
use super::rules::Rule;

pub const SITE: &str = "hall";
/// 0.98 s: a lease is good for one tick, and by the slowest clock a robot enters in the fifth tick after its report, 4.9 s later.
/// Without the 0.1 s for clocks that differ its area could be cleared just then.
pub const TICK_NS: u64 = 980_000_000;
/// Robots have registered after so many ticks, and nothing before the start carries them on any more: then the search begins.
pub(super) const BEFORE: u8 = 8;

/// Kinds of faults, as bits: of messages,
pub const MESSAGES: u8 = 1;
/// robots that are cut off,
pub const CUTS: u8 = 2;
/// processes that end,
pub const PROCESSES: u8 = 4;
/// starts of the mediator,
pub const MEDIATOR: u8 = 8;
/// a second robot of one identity,
pub const SECOND: u8 = 16;
/// robots that give up where they were going,
pub const MINDS: u8 = 32;
/// grants that are given back by the fence of the one before,
pub const FENCES: u8 = 64;
/// all of these,
pub const ALL: u8 = 127;
/// and robots that are cut off for good.
pub const AWAY: u8 = 128;

/// How far a search goes.
#[derive(Clone, Copy, Debug)]
pub struct Limits {
    pub ticks: u8,
    /// Faults in one run,
    pub faults: u8,
    /// of these kinds.
    pub kinds: u8,
    /// Orders of operators.
    pub orders: u8,
    /// The first robot is cut off for good when the search begins, just after it was granted its first area.
    pub gone: bool,
    pub without: Option<Rule>,
}

impl Limits {
    pub fn new(faults: u8, kinds: u8, orders: u8, ticks: u8) -> Self {
        Self {
            ticks,
            faults,
            kinds,
            orders,
            gone: false,
            without: None,
        }
    }

    pub fn gone(self) -> Self {
        Self { gone: true, ..self }
    }
}

#[derive(Clone, Debug)]
pub(super) struct Journal {
    pub(super) stored: Stored,
    /// Before the last write.
    pub(super) before: Option<Stored>,
}

/// A message that arrives later, or never.
#[derive(Clone)]
pub(super) enum Message {
    Report(Kept<RobotReport>),
    /// To a robot.
    Answer(u8, Kept<MediatorReport>),
}

impl Message {
    fn key(&self) -> (Option<u8>, u64) {
        match self {
            Self::Report(report) => (None, report.key()),
            Self::Answer(robot, answer) => (Some(*robot), answer.key()),
        }
    }
}

#[derive(Clone)]
pub struct World {
    pub(super) limits: Limits,
    pub(super) tick: u8,
    pub(super) manager: Kept<Manager>,
    pub(super) journal: Kept<Journal>,
    pub(super) starts: u8,
    /// A journal was lost, or its end: fences may begin anew.
    pub(super) lost: bool,
    pub(super) robots: [Robot; 3],
    pub(super) late: Option<Message>,
    /// The last fence by which somebody entered, and who, by area.
    pub(super) fences: [(u64, u8); 2],
    pub(super) wrong: Option<&'static str>,
}

impl World {
    pub fn new(limits: Limits) -> Self {
        let stored = Stored::new(1);
        let mut world = Self {
            limits,
            tick: 0,
            manager: Kept::new(manager(&stored, now_ns(0), 1)),
            journal: Kept::new(Journal {
                stored,
                before: None,
            }),
            starts: 1,
            lost: false,
            robots: [0, 1, 2].map(Robot::new),
            late: None,
            fences: [(0, 0); 2],
            wrong: None,
        };
        world.manage("nothing", |_, _| ());
        for robot in 0..2 {
            world.robots[robot].wants = false;
            world.robots[robot].start();
        }
        for _ in 0..BEFORE {
            (0..2).for_each(|robot| world.talk(robot, Fate::Arrive));
            world.pass();
        }
        let status = world.manager.get().status(now_ns(BEFORE));
        assert_eq!(status.awaited, [""; 0]);
        for robot in &mut world.robots {
            let client = robot.client.as_ref();
            assert!(robot.number == 2 || client.is_some_and(|own| own.get().is_registered()));
            robot.wants = true;
        }
        if limits.gone {
            // It asks, and is answered.
            world.talk(0, Fate::Arrive);
            assert!(world.robots[0].may_commit(world.tick, None));
            world.robots[0].is_cut = true;
        }
        world
    }

    pub fn key(&self) -> u64 {
        let mut hasher = DefaultHasher::new();
        for robot in &self.robots {
            let Robot {
                number: _,
                client,
                boots,
                body,
                committed,
                said_in,
                is_unaware,
                is_through,
                is_cut,
                talked,
                wants,
            } = robot;
            (client.as_ref().map(Kept::key), boots, body, committed).hash(&mut hasher);
            said_in.hash(&mut hasher);
            (is_cut, talked, wants, is_through, is_unaware).hash(&mut hasher);
        }
        let late = self.late.as_ref().map(Message::key);
        (self.tick, self.manager.key(), self.journal.key(), late).hash(&mut hasher);
        (
            self.limits.faults,
            self.limits.orders,
            self.starts,
            self.lost,
        )
            .hash(&mut hasher);
        (self.fences, self.wrong).hash(&mut hasher);
        hasher.finish()
    }

    /// What must never be.
    pub fn violation(&self) -> Option<String> {
        for (area, id) in AREAS.iter().enumerate() {
            let inside = self
                .robots
                .iter()
                .filter(|robot| robot.body & 1 << area != 0)
                .count();
            if inside > 1 {
                return Some(format!("{inside} robots are in area {id}"));
            }
        }
        self.wrong.map(str::to_owned)
    }
}

/// The mediator's clock.
pub(super) fn now_ns(tick: u8) -> u64 {
    100_000_000_000 + u64::from(tick) * TICK_NS
}
