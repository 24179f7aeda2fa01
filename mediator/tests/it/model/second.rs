//! Second processes with the identity of a robot, also several at once: each stands somewhere, asks for areas, and must get none. Its
//! body is put on the floor when nobody is there or may come, and the mediator knows of it: from then on nobody else may drive there.
//! Some have another floor, so that they are refused whoever else is heard; some do not know for a while where they are.

use contract::client::{Client, Situation};
use contract::floor::{Floor as Areas, FloorArea};
use contract::wire::{MediatorReport, RobotReport};

use super::UNKNOWN_MS;
use super::fleet::{Broken, Faults, Fleet};
use super::floor::{Floor, SILENT_NS};
use super::mediators::Mediator;
use super::robot::Robot;
use crate::random::Random;
use mediator::manager::Status;

const REPORT_MS: u64 = 200;
/// At most so many run at once,
const AT_ONCE: usize = 2;
/// for so long, where nothing happens to their robot's own process,
pub const FOR_MS: u64 = 8_000;
/// and elsewhere, so that they are found first.
const LONGER_MS: u64 = 20_000;
/// One that loses its pose finds it again after this at most.
const LOST_MS: u64 = 4_000;
/// Until its mediator has heard where one stands.
const HEARD_MS: u64 = 2 * REPORT_MS;

pub struct Second {
    pub robot: usize,
    pub boot_epoch: u64,
    pub client: Client,
    situation: Situation,
    /// It has another floor.
    is_refused: bool,
    /// It does not know where it is.
    lost_until_ms: u64,
    /// Since when the mediator that runs is told without a break where it stands.
    told_since_ms: Option<u64>,
    /// Where its body is, or will be.
    pub spot: usize,
    pub is_there: bool,
    /// It was while nobody spoke for its robot.
    was_alone: bool,
    since_ms: u64,
    pub until_ms: u64,
    pub report_ms: u64,
}

impl Second {
    /// It runs for so long at most.
    pub fn start(
        robot: usize,
        id: &str,
        floor: &Floor,
        (now_ms, for_ms): (u64, u64),
        is_refused: bool,
        random: &mut Random,
    ) -> Self {
        let areas = if is_refused {
            another_floor()
        } else {
            floor.setup.floor.clone()
        };
        let spot = random.below(floor.outside() as u64) as usize;
        let there = random.below(floor.limits.len() as u64) as usize;
        let name = |&area: &usize| floor.name(area).to_owned();
        let stands_in: Vec<String> = floor.spots[spot].iter().map(name).collect();
        let situation = Situation {
            located: true,
            wanted: { stands_in.iter().cloned() }
                .chain([name(&there)])
                .collect(),
            stands_in,
            ..Situation::default()
        };
        let boot_epoch = random.next() | 1;
        Self {
            robot,
            boot_epoch,
            client: Client::new(id, &floor.setup.site, boot_epoch).on(areas),
            situation,
            is_refused,
            lost_until_ms: 0,
            told_since_ms: None,
            spot,
            is_there: false,
            was_alone: false,
            since_ms: now_ms,
            until_ms: now_ms + random.below(for_ms),
            report_ms: 0,
        }
    }

    pub fn is_over(&self, now_ms: u64) -> bool {
        now_ms >= self.until_ms
    }

    /// Where one before it was, which is heard no more, is not what the mediator knows of this one.
    pub fn is_known_by_now(&self, now_ms: u64) -> bool {
        now_ms >= self.since_ms + SILENT_NS / 1_000_000 + 2 * REPORT_MS
    }

    pub fn receive(&mut self, message: &MediatorReport, now_ms: u64) {
        self.client.receive(message, now_ms * 1_000_000);
    }

    pub fn step(&mut self, now_ms: u64) -> Option<RobotReport> {
        let mut situation = self.situation.clone();
        if now_ms < self.lost_until_ms {
            situation.located = false;
            situation.stands_in.clear();
            self.told_since_ms = None;
        }
        let is_located = situation.located;
        let news = self.client.step(situation, now_ms * 1_000_000, SILENT_NS);
        let due = news || now_ms >= self.report_ms + REPORT_MS;
        due.then(|| {
            self.report_ms = now_ms;
            if is_located {
                self.told_since_ms.get_or_insert(now_ms);
            }
            self.client.report()
        })
    }

    /// For people.
    pub fn describe(&self, now_ms: u64) -> String {
        format!(
            "{} of robot {}{}{}, {} spot {}, since {} ms, told since {:?}",
            self.boot_epoch,
            self.robot,
            if self.is_refused { ", refused" } else { "" },
            if now_ms < self.lost_until_ms {
                ", lost"
            } else {
                ""
            },
            if self.is_there { "in" } else { "not yet in" },
            self.spot,
            self.since_ms,
            self.told_since_ms,
        )
    }

    /// Whoever was told where it stands is gone.
    pub fn tells_anew(&mut self) {
        self.told_since_ms = None;
    }

    /// For so long the mediator knows that somebody is there that nobody enters any more, whatever was granted before.
    fn has_said(&self, area: usize, floor: &Floor, now_ms: u64) -> bool {
        let since_ms = self.told_since_ms.unwrap_or(now_ms);
        floor.spots[self.spot].contains(&area) && now_ms >= since_ms + HEARD_MS + UNKNOWN_MS
    }

    /// Nothing is granted to it, nor inherited by it.
    pub fn assert_has_nothing(&self, floor: &Floor) {
        for area in 0..floor.limits.len() {
            let name = floor.name(area);
            assert!(!self.client.holds(name), "the second process has {name}");
        }
    }
}

/// Of which no site here knows anything.
fn another_floor() -> Areas {
    Areas::new(vec![FloorArea {
        id: "elsewhere".into(),
        capacity: 1,
        min_m: [0.0, 0.0],
        max_m: [1.0, 1.0],
    }])
}

impl Fleet {
    /// Somebody switches on a second process of a robot, which ends again.
    pub fn step_seconds(&mut self, faults: Faults, random: &mut Random) {
        let now_ms = self.now_ms;
        self.seconds.retain(|own| !own.is_over(now_ms));
        self.clear_of_seconds();
        if faults.seconds && self.seconds.len() < AT_ONCE && random.below(100) == 0 {
            let number = random.below(self.robots.len() as u64) as usize;
            let is_refused = random.chance(40);
            let robot = &self.robots[number];
            // Of two that nobody hears, the first one that is heard speaks for the robot.
            let is_heard = |own: &Mediator| {
                let Some(manager) = own.manager.as_ref() else {
                    // What it took in last may not be in the journal.
                    return false;
                };
                let mut robots = manager.status(now_ms * 1_000_000).robots.into_iter();
                own.journal.knows(&robot.id) && robots.all(|own| own.id != robot.id || own.heard)
            };
            let another_speaks = !self.is_unheard(number) && self.mediators.iter().all(is_heard);
            if is_refused || another_speaks {
                let for_ms = if faults.crashes || faults.cuts > 0 {
                    LONGER_MS
                } else {
                    FOR_MS
                };
                let times = (now_ms, for_ms);
                let second =
                    Second::start(number, &robot.id, &self.floor, times, is_refused, random);
                self.seconds.push(second);
                self.tally.seconds += 1;
                self.tally.others_floor += u64::from(is_refused);
            }
        }
        for number in 0..self.seconds.len() {
            self.second_ms = now_ms;
            if self.may_be_put_down(&self.seconds[number]) {
                self.seconds[number].is_there = true;
                self.tally.bodies += 1;
            }
            let is_alone = self.is_unheard(self.seconds[number].robot);
            let second = &mut self.seconds[number];
            let id = &self.robots[second.robot].id;
            let is_known = |own: &Mediator| own.journal.knows_second(id, second.boot_epoch);
            // Of one that is not in a journal yet, and loses its pose, nobody knows anything after a start.
            if now_ms >= second.lost_until_ms
                && random.below(200) == 0
                && self.mediators.iter().all(is_known)
            {
                second.lost_until_ms = now_ms + random.below(LOST_MS);
                self.tally.lost_seconds += 1;
            }
            if is_alone && second.is_there && !std::mem::replace(&mut second.was_alone, true) {
                self.tally.alone += 1;
            }
            let second = &self.seconds[number];
            assert!(
                !second.client.is_registered(),
                "seed {}, {now_ms} ms: a second process of {} speaks for it: {}",
                self.seed,
                self.robots[second.robot].id,
                self.explain()
            );
            let second = &mut self.seconds[number];
            second.assert_has_nothing(&self.floor);
            if let Some(report) = second.step(now_ms) {
                let robot = second.robot;
                let report = self.as_the_first(robot, report);
                self.say(&report, faults, random);
            }
        }
    }

    /// Who has ended a second process that was found takes its body away, looks, and says so. So does who was told that a robot has started
    /// anew elsewhere.
    fn clear_of_seconds(&mut self) {
        let (seconds, elsewhere) = (self.tally.seconds, self.tally.started_elsewhere);
        if seconds + elsewhere == 0 || !self.now_ms.is_multiple_of(REPORT_MS) {
            return;
        }
        let now_ns = self.now_ms * 1_000_000;
        let claimed = |area: usize| {
            let mut seconds = self.seconds.iter();
            seconds.any(|own| self.floor.spots[own.spot].contains(&area))
        };
        for manager in { self.mediators.iter_mut() }.filter_map(|own| own.manager.as_mut()) {
            let Status { robots, areas, .. } = manager.status(now_ns);
            // A robot that he sees, and that is not heard, or is heard elsewhere, he might mean.
            let is_seen = |robot: &Robot, area: usize| {
                let own = &areas[area];
                let mut holders = own.holders.iter();
                let is_known =
                    own.standing.contains(&robot.id) || holders.any(|(id, _)| *id == robot.id);
                let mut robots = robots.iter().filter(|own| own.id == robot.id);
                let is_meant = !is_known || robots.any(|own| !own.heard);
                robot.stands_in(&self.floor).contains(&area) && is_meant
            };
            for area in 0..self.floor.limits.len() {
                let name = self.floor.name(area);
                let blocks = |all: &Vec<String>| all.iter().any(|own| own == name);
                let blocked = robots.iter().any(|own| blocks(&own.second_in));
                let is_clear = !claimed(area) && !self.robots.iter().any(|own| is_seen(own, area));
                if blocked && is_clear {
                    // Somebody may still be on its way there.
                    let done = manager.clear(name, true, now_ns).is_ok();
                    self.tally.orders += u64::from(done && elsewhere > 0);
                }
            }
        }
    }

    /// Nobody speaks for the robot, or is heard.
    fn is_unheard(&self, robot: usize) -> bool {
        let process = self.robots[robot].process.as_ref();
        process.is_none_or(|own| !own.client.is_registered()) || self.is_cut(robot)
    }

    /// Nobody begins to reach into an area that is full of bodies with others' names, for all that the mediator was told. Who says that it
    /// cannot stop before it is believed, and keeps what it was granted.
    pub fn assert_enters_nothing_full(&self, robot: &Robot) {
        let Some(next) = robot.crossing.filter(|_| !robot.was_mistaken) else {
            return;
        };
        let here = &self.floor.spots[robot.spot];
        for &area in self.floor.spots[next]
            .iter()
            .filter(|&&area| !here.contains(&area) && !robot.insists_on(area))
        {
            let says = |own: &&Second| own.has_said(area, &self.floor, self.now_ms);
            let bodies = self.seconds.iter().filter(says).count();
            assert!(
                bodies < self.floor.setup.areas[area].capacity as usize,
                "seed {}, {} ms: {} enters an area that is full: {}",
                self.seed,
                self.now_ms,
                robot.id,
                self.explain()
            );
        }
    }

    /// The robot's own process is heard no more. A second one that was not found yet would speak for it then: people end it.
    pub fn end_seconds_that_were_not_found(&mut self, robot: usize) {
        let id = &self.robots[robot].id;
        let mediators = &self.mediators;
        self.seconds.retain(|own| {
            let mut journals = mediators.iter().map(|mediator| &mediator.journal);
            own.is_refused
                || own.robot != robot
                || journals.all(|journal| journal.is_retired(id, own.boot_epoch))
        });
    }

    /// A mediator that takes the second process for the first one hears this, or one that takes no notice of where it stands.
    fn as_the_first(&self, robot: usize, report: RobotReport) -> RobotReport {
        let ignores = match self.broken {
            Some(Broken::IgnoresSeconds) => true,
            Some(Broken::ForgetsSeconds) => self.is_unheard(robot),
            _ => false,
        };
        if ignores {
            let stands_in = Vec::new();
            return RobotReport {
                stands_in,
                ..report
            };
        }
        let first = self.robots[robot].process.as_ref();
        match first.filter(|_| self.broken == Some(Broken::PromotesSecond)) {
            Some(first) => RobotReport {
                stands_in: report.stands_in,
                located: report.located,
                access: report.access,
                ..first.client.clone().report()
            },
            None => report,
        }
    }

    /// Nobody is or may come where its body is to be, and all mediators know of it.
    fn may_be_put_down(&self, second: &Second) -> bool {
        if second.is_there || !second.is_known_by_now(self.now_ms) {
            return false;
        }
        let areas = &self.floor.spots[second.spot];
        let is_away = |robot: &Robot| {
            let client = robot.process.as_ref().map(|own| &own.client);
            let has = |&area: &usize| client.is_some_and(|own| own.holds(self.floor.name(area)));
            let there = robot.stands_in(&self.floor);
            { areas.iter() }.all(|area| !there.contains(area) && !has(area))
        };
        let id = &self.robots[second.robot].id;
        let is_known = |mediator: &Mediator| {
            let status =
                { mediator.manager.as_ref() }.map(|own| own.status(self.now_ms * 1_000_000));
            status.is_some_and(|status| {
                let mut robots = status.robots.iter();
                let second_in = robots.find(|own| own.id == *id).map(|own| &own.second_in);
                areas.iter().all(|&area| {
                    let own = &status.areas[area];
                    let is_held = second_in.is_some_and(|all| all.contains(&own.id));
                    let stands = is_held && own.seconds == [id.as_str()];
                    let ignored =
                        self.broken == Some(Broken::IgnoresSeconds) && own.seconds.is_empty();
                    (stands || ignored) && own.standing.is_empty() && own.holders.is_empty()
                })
            })
        };
        let mut others = self.seconds.iter().filter(|own| own.is_there);
        let is_free = others.all(|own| {
            let there = &self.floor.spots[own.spot];
            areas.iter().all(|area| !there.contains(area))
        });
        is_free && self.robots.iter().all(is_away) && self.mediators.iter().all(is_known)
    }
}
