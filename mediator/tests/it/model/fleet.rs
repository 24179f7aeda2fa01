//! Robots on a floor, one mediator, and the network between them.

use std::collections::BTreeMap;

use super::cores::Core;
use super::floor::{Floor, SILENT_NS};
use super::journal::Journal;
use super::mediators::Mediator;
use super::robot::{Process, Robot};
use super::second::{self, Second};
use super::tally::Tally;
use crate::random::Random;
use contract::client::Client;
use contract::wire::{MediatorReport, RobotReport};
use mediator::manager::CoordinationStatus;

pub(super) const STEP_MS: u64 = 20;
const REPORT_MS: u64 = 200;
/// No message is later than that, but those that come again.
pub(super) const LATEST_MS: u64 = 2_000;
/// The first mediator has started at 0: long enough before that nobody may still enter what one before it has granted.
pub(super) const BEGINS_MS: u64 = 10_000;

/// What goes wrong.
#[derive(Clone, Copy, PartialEq, Eq)]
pub struct Faults {
    /// Messages are lost, repeated, or late.
    pub network: bool,
    /// Messages come again from long ago, and reports with levels and fences of long ago.
    pub replays: bool,
    /// Robots and mediator crash.
    pub crashes: bool,
    /// The journal may lose its last writes with a crash.
    pub power: bool,
    /// With a crash it may be gone, or replaced by an older one.
    pub journal: bool,
    /// How many of a thousand orders are never carried out.
    pub stuck_per_mille: u64,
    /// Robots have second processes.
    pub seconds: bool,
    /// So many links are cut for seconds at the same time, each of a robot to one mediator or to all.
    pub cuts: usize,
    /// An operator orders whatever he may, at any moment, and says only what he sees.
    pub operator: bool,
    /// Robots do not know for seconds where they are, or are wrong about it.
    pub poses: bool,
    /// Robots take as long as they may from when they cannot stop any more until they reach in.
    pub slow: bool,
    /// A second mediator runs for a while, with a journal of its own.
    pub spare: bool,
    /// One that runs when nothing goes wrong any more runs on.
    pub spare_stays: bool,
    /// Everybody crashes once in this many steps, on average,
    pub every: u64,
    /// and a mediator in one of so many of those in which it writes.
    pub stops_at: u64,
}

impl Faults {
    pub const NONE: Self = Self {
        network: false,
        replays: false,
        crashes: false,
        power: false,
        journal: false,
        stuck_per_mille: 0,
        seconds: false,
        cuts: 0,
        operator: false,
        poses: false,
        slow: false,
        spare: false,
        spare_stays: false,
        every: u64::MAX,
        stops_at: 40,
    };
    pub const ALL: Self = Self {
        network: true,
        replays: true,
        crashes: true,
        power: true,
        journal: false,
        stuck_per_mille: 150,
        seconds: false,
        cuts: 0,
        operator: false,
        poses: false,
        slow: false,
        spare: false,
        spare_stays: false,
        every: 250,
        stops_at: 40,
    };

    /// And an operator orders what he may, with time between two crashes in which it matters. A report that comes after all from before
    /// an area was cleared is believed, and blocks it: so none comes.
    pub fn and_orders(self) -> Self {
        Self {
            cuts: self.cuts.max(1),
            operator: true,
            replays: false,
            every: 1_000,
            stops_at: 400,
            ..self
        }
    }
}

/// Between a mediator, by number, and a robot.
#[derive(Clone)]
pub(super) enum Message {
    ToMediator(usize, RobotReport),
    ToRobot(usize, MediatorReport),
}

/// Where a mediator stops for good within a step.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Point {
    BeforeJournal,
    AfterJournal,
    AmidMessages,
    AfterMessages,
}

impl Point {
    pub const ALL: [Self; 4] = [
        Self::BeforeJournal,
        Self::AfterJournal,
        Self::AmidMessages,
        Self::AfterMessages,
    ];
}

/// What is made wrong on purpose, to see that it is noticed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Broken {
    /// A restarted mediator knows its epoch and nothing else.
    ForgetsJournal,
    /// Nor does it wait for robots.
    AwaitsNobody,
    /// A restarted mediator does not know that it has restarted.
    ForgetsEpoch,
    /// A mediator that stops has sent what it had not written.
    TellsFirst,
    /// What comes too late names the present grant.
    NoFences,
    /// Robots do not wait for grants.
    Reckless,
    /// They enter what they were granted, whenever that was.
    NoLease,
    /// The mediator takes a second process for the first one.
    PromotesSecond,
    /// It lets robots into areas that an operator has closed.
    IgnoresClosed,
    /// A restarted mediator does not know which areas are closed.
    ForgetsClosed,
    /// It does not wait until a robot enters nothing any more before it clears what that was granted.
    ClearsAtOnce,
    /// It takes every other mediator to be gone.
    NeverStandsBy,
    /// Robots are wrong about where they are, and everybody relies on it.
    WrongPose,
    /// The mediator asks for no grant back.
    NeverRevokes,
    /// It takes no notice of where second processes of robots stand.
    IgnoresSeconds,
    /// Or none any more when the first ones are silent.
    ForgetsSeconds,
}

pub struct Fleet {
    pub(super) floor: Floor,
    pub(super) robots: Vec<Robot>,
    pub(super) seconds: Vec<Second>,
    /// When one of those ran last.
    pub(super) second_ms: u64,
    /// The first one, and a spare one while there is one.
    pub(super) mediators: Vec<Mediator>,
    network: Vec<(u64, Message)>,
    /// Robots that are out of reach, of which mediator, or of all, and until when.
    cuts: Vec<(usize, Option<usize>, u64)>,
    /// Messages of long ago.
    past: Vec<Message>,
    /// Until then some arrive.
    pub(super) replays_until_ms: u64,
    pub(super) now_ms: u64,
    pub(super) seed: u64,
    pub(super) accusations: Vec<String>,
    pub(super) tally: Tally,
    /// Steps of mediators so far that had something to write.
    pub(super) writes: u64,
    /// The mediator stops in the step with this number of those that write, at that point.
    pub(super) stop: Option<(u64, Point)>,
    pub(super) broken: Option<Broken>,
    /// Nothing goes wrong any more.
    pub(super) is_recovered: bool,
    /// The spare mediator is not switched off any more.
    pub(super) spare_stays: bool,
    /// By area: since when an operator has closed it, for all that a single mediator can know.
    pub(super) closed: BTreeMap<usize, u64>,
}

impl Fleet {
    pub fn new((floor, robots): (Floor, Vec<Robot>), seed: u64) -> Self {
        Self {
            floor,
            robots,
            seconds: Vec::new(),
            second_ms: 0,
            mediators: vec![Mediator::new(Journal::of(1), 0)],
            network: Vec::new(),
            cuts: Vec::new(),
            past: Vec::new(),
            replays_until_ms: 0,
            now_ms: BEGINS_MS,
            seed,
            accusations: Vec::new(),
            tally: Tally::default(),
            writes: 0,
            stop: None,
            broken: None,
            is_recovered: false,
            spare_stays: false,
            closed: BTreeMap::new(),
        }
    }

    /// Stops the mediator once, in step number `write` of those that have something to write.
    pub fn stop_at(&mut self, write: u64, point: Point) {
        self.stop = Some((write, point));
    }

    pub fn break_something(&mut self, broken: Broken) {
        self.broken = Some(broken);
        for robot in &mut self.robots {
            robot.reckless = broken == Broken::Reckless;
            robot.no_lease = broken == Broken::NoLease;
        }
    }

    /// Steps of mediators so far that had something to write.
    pub fn writes(&self) -> u64 {
        self.writes
    }

    pub fn run(&mut self, for_ms: u64, faults: Faults, random: &mut Random) {
        let _core = Core::wait();
        let end_ms = self.now_ms + for_ms;
        while self.now_ms < end_ms {
            self.now_ms += STEP_MS;
            if faults.replays {
                self.replays_until_ms = self.now_ms + LATEST_MS;
            }
            if faults.crashes {
                self.crash_somebody(faults, random);
            }
            self.start_whoever_is_due(random);
            for robot in &mut self.robots {
                robot.is_hindered = faults.cuts > 0;
                robot.is_slow = faults.slow;
            }
            self.cut_somebody_off(faults.cuts, random);
            if faults.operator {
                self.operate(random);
            }
            if faults.poses {
                self.mislead_somebody(random);
            }
            self.keep_a_spare(faults.spare, random);
            self.deliver(faults, random);
            self.drive(random);
            self.step_robots(faults, random);
            self.step_seconds(faults, random);
            for number in 0..self.mediators.len() {
                self.step_mediator(number, None, faults, random);
            }
            self.judge();
        }
    }

    /// Whoever is down starts at once, robots know where they are, and operators have put everything back.
    pub fn recover(&mut self, faults: Faults) {
        for mediator in &mut self.mediators {
            mediator.restart_ms = self.now_ms;
        }
        self.spare_stays = faults.spare_stays;
        self.tally.stays += u64::from(faults.spare_stays && self.mediators.len() == 2);
        self.is_recovered = true;
        self.open_all();
        for second in &mut self.seconds {
            second.until_ms = second.until_ms.min(self.now_ms + second::FOR_MS);
        }
        for robot in &mut self.robots {
            robot.restart_ms = self.now_ms;
            robot.is_away = false;
            let mistake = robot.mistake.take();
            robot.is_found(mistake);
        }
    }

    pub fn moves(&self) -> Vec<u64> {
        self.robots.iter().map(|robot| robot.moves).collect()
    }

    pub fn priority(&self, robot: usize) -> u32 {
        let id = &self.robots[robot].id;
        let found = { self.floor.setup.robots.iter() }.find(|own| own.id == *id);
        found.map_or(0, |own| own.priority)
    }

    pub fn tally(&self) -> Tally {
        let mut tally = self.tally;
        tally.moves = self.moves().iter().sum();
        for process in self
            .robots
            .iter()
            .filter_map(|robot| robot.process.as_ref())
        {
            tally.add_client(&process.client.counters());
        }
        for mediator in &self.mediators {
            if let Some(manager) = &mediator.manager {
                tally.add_manager(&manager.counters());
            }
        }
        tally
    }

    /// Coordinations that the mediator which goes on remembers or runs.
    pub fn coordinations(&self) -> Vec<CoordinationStatus> {
        let mut managers = { self.mediators.iter() }.filter_map(|own| own.manager.as_ref());
        let manager = managers.find(|manager| !manager.stands_by());
        let status = manager.map(|manager| manager.status(self.now_ms * 1_000_000));
        status.map_or_else(Vec::new, |status| status.coordinations)
    }

    pub fn explain(&self) -> String {
        let now_ns = self.now_ms * 1_000_000;
        let managers = self.mediators.iter().map(|own| own.manager.as_ref());
        let status: Vec<_> = { managers.clone() }
            .map(|manager| manager.map(|manager| manager.status(now_ns)))
            .collect();
        let why = { self.robots.iter() }.map(|robot| {
            let why: Vec<_> = { managers.clone() }
                .map(|manager| manager.map(|manager| manager.why(&robot.id, now_ns)))
                .collect();
            let client = robot.process.as_ref().map(|process| {
                let client = &process.client;
                (
                    client.is_acquired(),
                    client.coordination().map(|own| (own.0, own.2)),
                    client.counters(),
                )
            });
            format!(
                "{} in {:?}, {}, client {client:?}: {why:?}",
                robot.id,
                robot.stands_in(&self.floor),
                robot.describe(),
            )
        });
        let seconds = self.seconds.iter().map(|own| own.describe(self.now_ms));
        format!(
            "{status:#?}\n{:#?}\n{:#?}\naccusations: {:#?}",
            why.collect::<Vec<_>>(),
            seconds.collect::<Vec<_>>(),
            self.accusations
        )
    }

    /// These robots keep the rules, so the mediator must never accuse one.
    pub fn assert_no_violation_was_claimed(&self) {
        assert!(
            self.accusations.is_empty(),
            "seed {}: {:#?}",
            self.seed,
            self.accusations
        );
    }

    fn crash_somebody(&mut self, faults: Faults, random: &mut Random) {
        for number in 0..self.robots.len() {
            let robot = &mut self.robots[number];
            if let Some(process) = &robot.process
                && random.below(faults.every) == 0
            {
                self.tally.add_client(&process.client.counters());
                robot.crash(self.now_ms, random);
                self.tally.robot_crashes += 1;
                self.end_seconds_that_were_not_found(number);
            }
        }
        for number in 0..self.mediators.len() {
            if self.mediators[number].manager.is_some() && random.below(faults.every) == 0 {
                self.crash_mediator(number, faults, random);
            }
        }
    }

    fn cut_somebody_off(&mut self, most: usize, random: &mut Random) {
        let now_ms = self.now_ms;
        self.cuts.retain(|(.., until_ms)| now_ms < *until_ms);
        self.cuts.truncate(most);
        if self.cuts.len() < most && random.below(50) == 0 {
            let robot = random.below(self.robots.len() as u64) as usize;
            // Where there is only one, mostly of that.
            let mediator = { random.chance(50) }.then(|| random.below(self.mediators.len() as u64));
            let mediator = mediator.map(|number| number as usize);
            self.cuts
                .push((robot, mediator, now_ms + 5_000 + random.below(7_000)));
            self.tally.cuts += 1;
            self.end_seconds_that_were_not_found(robot);
        }
        for (robot, ..) in &self.cuts {
            self.robots[*robot].lost_ms = now_ms;
        }
    }

    /// The robot's own process is out of reach.
    pub(super) fn is_cut(&self, robot: usize) -> bool {
        self.cuts.iter().any(|(cut, ..)| *cut == robot)
    }

    fn is_cut_off(&self, message: &Message) -> bool {
        let (number, id, boot_epoch) = match message {
            Message::ToMediator(number, own) => (number, &own.robot_id, own.boot_epoch),
            Message::ToRobot(number, own) => (number, &own.robot_id, own.boot_epoch),
        };
        // Second processes have links of their own.
        let mut seconds = self.seconds.iter();
        if seconds.any(|own| own.boot_epoch == boot_epoch) {
            return false;
        }
        self.cuts.iter().any(|(robot, mediator, _)| {
            self.robots[*robot].id == *id && mediator.is_none_or(|own| own == *number)
        })
    }

    fn start_whoever_is_due(&mut self, random: &mut Random) {
        for robot in &mut self.robots {
            if robot.process.is_none() && !robot.is_away && self.now_ms >= robot.restart_ms {
                let client = Client::new(&robot.id, &self.floor.setup.site, random.next() | 1);
                let client = client.on(self.floor.setup.floor.clone());
                robot.process = Some(Process::new(client));
                robot.until_ms = self.now_ms + random.below(500);
            }
        }
        for number in 0..self.mediators.len() {
            self.start_mediator_if_due(number);
        }
    }

    fn deliver(&mut self, faults: Faults, random: &mut Random) {
        let now_ms = self.now_ms;
        let due = self.network.extract_if(.., |(at_ms, _)| *at_ms <= now_ms);
        let mut due: Vec<Message> = due.map(|(_, message)| message).collect();
        due.retain(|message| !self.is_cut_off(message));
        if faults.replays && !self.past.is_empty() && random.chance(5) {
            due.push(self.past[random.below(self.past.len() as u64) as usize].clone());
            self.tally.replayed += 1;
        }
        for message in due {
            match message {
                Message::ToMediator(number, report) => {
                    self.step_mediator(number, Some(&report), faults, random);
                }
                Message::ToRobot(_, message) => {
                    let mut robots = self.robots.iter_mut().enumerate();
                    let robot = robots.find(|(_, robot)| robot.id == message.robot_id);
                    let Some((number, robot)) = robot else {
                        continue;
                    };
                    for second in self.seconds.iter_mut().filter(|own| own.robot == number) {
                        second.receive(&message, now_ms);
                    }
                    if let Some(process) = &mut robot.process {
                        process.client.receive(&message, now_ms * 1_000_000);
                    }
                }
            }
        }
    }

    /// All mediators hear robots.
    pub(super) fn say(&mut self, report: &RobotReport, faults: Faults, random: &mut Random) {
        for number in 0..self.mediators.len() {
            let message = Message::ToMediator(number, report.clone());
            self.send(message, faults, random);
        }
    }

    pub(super) fn send(&mut self, message: Message, faults: Faults, random: &mut Random) {
        if self.is_cut_off(&message) {
            return;
        }
        if faults.replays && self.past.len() < 100 {
            self.past.push(message.clone());
        } else if faults.replays && random.chance(10) {
            let place = random.below(100) as usize;
            self.past[place] = message.clone();
        }
        if !faults.network {
            self.network.push((self.now_ms + STEP_MS, message));
            return;
        }
        let copies = match random.below(10) {
            0..3 => 0,
            3 => 2,
            _ => 1,
        };
        for message in std::iter::repeat_n(message, copies) {
            let delay_ms = if random.chance(20) {
                random.below(LATEST_MS)
            } else {
                random.below(40)
            };
            self.network.push((self.now_ms + delay_ms, message));
        }
    }

    fn drive(&mut self, random: &mut Random) {
        let now_ms = self.now_ms;
        let (first, lay_by) = (self.floor.first, self.floor.lay_by);
        for index in 0..self.robots.len() {
            let (was, did_cross) = (self.robots[index].spot, self.robots[index].crossing);
            self.robots[index].drive(&self.floor, now_ms, random);
            let robot = &self.robots[index];
            if did_cross.is_none() {
                self.assert_enters_nothing_closed(robot);
                self.assert_enters_nothing_full(robot);
            }
            let entered_first = robot.spot != was && Some(robot.spot) == first;
            // One that is told to get out of the way of a net may still arrive where it could not stop before.
            let ordered = { robot.process.as_ref() }
                .is_some_and(|own| own.client.is_acquired() && own.event() == "go-1");
            if robot.role == "emergency" && entered_first && ordered {
                // Judged by the bodies: the robot that it passes stands completely aside, or was carried away meanwhile.
                let outside = self.floor.outside();
                let aside = self.robots.iter().any(|other| {
                    let is_aside = Some(other.spot) == lay_by || other.spot == outside;
                    let is_aside = is_aside && other.crossing.is_none();
                    other.role == "normal" && (is_aside || other.was_mistaken)
                });
                assert!(
                    aside,
                    "seed {}, {now_ms} ms: it passes nobody: {}",
                    self.seed,
                    self.explain()
                );
                self.tally.passed += 1;
            }
        }
    }

    fn step_robots(&mut self, faults: Faults, random: &mut Random) {
        let now_ms = self.now_ms;
        let fences = self.broken != Some(Broken::NoFences);
        let mut reports = Vec::new();
        for robot in &mut self.robots {
            if let Some(process) = &mut robot.process {
                process.obey(random, faults.stuck_per_mille);
            }
            let news = robot.step(&self.floor, now_ms, SILENT_NS, random);
            if let Some(process) = &mut robot.process
                && (news || now_ms >= robot.report_ms + REPORT_MS)
            {
                robot.report_ms = now_ms;
                if faults.replays && random.chance(2) {
                    if random.chance(50) {
                        let old = stale(&mut process.client, &self.past, random);
                        self.tally.stale_levels += u64::from(old.is_some());
                        reports.extend(old);
                    } else if self.tally.power_losses + self.tally.journals_lost + self.tally.spares
                        == 0
                        && let Some(late) = late_release(&mut process.client, fences)
                    {
                        // Where the journal has lost entries, the mediator believes a robot's first report.
                        self.tally.late_releases += 1;
                        reports.push(late);
                    }
                }
                reports.push(process.client.report());
            }
        }
        for report in reports {
            self.say(&report, faults, random);
        }
    }

    /// Judges by where the bodies are, not by what anybody says.
    fn judge(&self) {
        let mut counts = vec![0; self.floor.limits.len()];
        self.each_inside(|area, _| counts[area] += 1);
        for (area, (count, capacity)) in counts.into_iter().zip(&self.floor.limits).enumerate() {
            assert!(
                count <= *capacity,
                "seed {}, {} ms: area {} holds {capacity}, and {:?} are in it: {}",
                self.seed,
                self.now_ms,
                self.floor.name(area),
                self.who_is_inside(area),
                self.explain()
            );
        }
    }

    /// Each area in which a body is, and whose.
    fn each_inside<'a>(&'a self, mut add: impl FnMut(usize, &'a str)) {
        // Who was wrong about where it is has given back what it is in.
        for robot in self.robots.iter().filter(|robot| !robot.was_mistaken) {
            robot.each_area(&self.floor, |area| add(area, &robot.id));
        }
        for second in self.seconds.iter().filter(|own| own.is_there) {
            for &area in &self.floor.spots[second.spot] {
                add(area, "a second one");
            }
        }
    }

    fn who_is_inside(&self, area: usize) -> Vec<&str> {
        let mut robots = Vec::new();
        self.each_inside(|at, who| robots.extend((at == area).then_some(who)));
        robots
    }
}

/// A new report with levels and fences of long ago, as from a part of the robot that has fallen behind.
fn stale(client: &mut Client, past: &[Message], random: &mut Random) -> Option<RobotReport> {
    let Message::ToMediator(_, old) = past.get(random.below(100) as usize)? else {
        return None;
    };
    let mut report = client.report();
    let same = old.robot_id == report.robot_id
        && old.boot_epoch == report.boot_epoch
        && old.session == report.session
        && old.mediator_epoch == report.mediator_epoch;
    if same {
        report.access.clone_from(&old.access);
        report.revocations.clone_from(&old.revocations);
        if let (Some(control), Some(old)) = (&mut report.control, &old.control) {
            *control = old.clone();
        }
    }
    Some(report)
}

/// A new report that gives back what the robot has, by fences of grants before: as a release that comes too late would, if
/// its run could be mistaken for the present one.
fn late_release(client: &mut Client, fences: bool) -> Option<RobotReport> {
    let mut report = client.report();
    let mut found = false;
    for access in &mut report.access {
        if let Some(level) = &mut access.level
            && access.fence > 1
        {
            // Path 0 ends with `released`.
            (level.path, level.progress) = (0, 4);
            access.fence -= u64::from(fences);
            found = true;
        }
    }
    found.then_some(report)
}
