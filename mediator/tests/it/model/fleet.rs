//! Robots on a floor, one mediator, and the network between them.

use std::collections::BTreeMap;

use super::floor::{Floor, SILENT_NS};
use super::journal::{Journal, Left};
use super::robot::{Process, Robot};
use super::second::Second;
use super::tally::Tally;
use crate::random::Random;
use contract::client::Client;
use contract::wire::{MediatorReport, RobotReport};
use mediator::journal::Entry;
use mediator::manager::{Alarm, BadReport, ClearError, CoordinationStatus, Manager};

const STEP_MS: u64 = 20;
const REPORT_MS: u64 = 200;
/// No message is later than that, but those that come again.
const LATEST_MS: u64 = 2_000;
/// The first mediator has started at 0: long enough before that nobody may still enter what one before it has granted.
const BEGINS_MS: u64 = 10_000;

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
    /// A robot is out of reach for seconds, and an operator clears areas that he sees empty.
    pub cuts: bool,
    /// Everybody crashes once in this many steps, on average.
    pub every: u64,
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
        cuts: false,
        every: u64::MAX,
    };
    pub const ALL: Self = Self {
        network: true,
        replays: true,
        crashes: true,
        power: true,
        journal: false,
        stuck_per_mille: 150,
        seconds: false,
        cuts: false,
        every: 250,
    };
}

#[derive(Clone)]
enum Message {
    ToMediator(RobotReport),
    ToRobot(MediatorReport),
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
}

pub struct Fleet {
    floor: Floor,
    robots: Vec<Robot>,
    second: Option<Second>,
    manager: Option<Manager>,
    manager_restart_ms: u64,
    journal: Journal,
    network: Vec<(u64, Message)>,
    /// A robot that is out of reach, and until when.
    cut: Option<(usize, u64)>,
    /// Messages of long ago.
    past: Vec<Message>,
    /// Until then some arrive.
    replays_until_ms: u64,
    now_ms: u64,
    seed: u64,
    accusations: Vec<String>,
    tally: Tally,
    /// Steps of mediators so far that had something to write.
    writes: u64,
    /// The mediator stops in the step with this number of those that write, at that point.
    stop: Option<(u64, Point)>,
    broken: Option<Broken>,
}

impl Fleet {
    pub fn new((floor, robots): (Floor, Vec<Robot>), seed: u64) -> Self {
        Self {
            floor,
            robots,
            second: None,
            manager: None,
            manager_restart_ms: 0,
            journal: Journal::default(),
            network: Vec::new(),
            cut: None,
            past: Vec::new(),
            replays_until_ms: 0,
            now_ms: BEGINS_MS,
            seed,
            accusations: Vec::new(),
            tally: Tally::default(),
            writes: 0,
            stop: None,
            broken: None,
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
                robot.is_hindered = faults.cuts;
            }
            if faults.cuts {
                self.cut_somebody_off(random);
                self.clear_what_is_empty(random);
            } else {
                self.cut = None;
            }
            self.deliver(faults, random);
            self.drive(random);
            self.step_robots(faults, random);
            self.step_second(faults, random);
            self.step_manager(None, faults, random);
            self.judge();
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
        if let Some(manager) = &self.manager {
            tally.add_manager(&manager.counters());
        }
        tally
    }

    /// Coordinations that this mediator remembers or runs.
    pub fn coordinations(&self) -> Vec<CoordinationStatus> {
        let status =
            { self.manager.as_ref() }.map(|manager| manager.status(self.now_ms * 1_000_000));
        status.map_or_else(Vec::new, |status| status.coordinations)
    }

    pub fn explain(&self) -> String {
        let now_ns = self.now_ms * 1_000_000;
        let status = self.manager.as_ref().map(|manager| manager.status(now_ns));
        let why = { self.robots.iter() }.map(|robot| {
            let why = { self.manager.as_ref() }.map(|manager| manager.why(&robot.id, now_ns));
            let client = robot.process.as_ref().map(|process| {
                let client = &process.client;
                (
                    client.is_acquired(),
                    client.coordination().map(|own| (own.0, own.2)),
                    client.counters(),
                )
            });
            format!(
                "{} in {:?}, client {client:?}: {why:?}",
                robot.id,
                robot.stands_in(&self.floor),
            )
        });
        format!(
            "{status:#?}\n{:#?}\naccusations: {:#?}",
            why.collect::<Vec<_>>(),
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
        for robot in &mut self.robots {
            if let Some(process) = &robot.process
                && random.below(faults.every) == 0
            {
                self.tally.add_client(&process.client.counters());
                robot.crash(self.now_ms, random);
                self.tally.robot_crashes += 1;
            }
        }
        if self.manager.is_some() && random.below(faults.every) == 0 {
            self.crash_manager(faults, random);
        }
    }

    fn cut_somebody_off(&mut self, random: &mut Random) {
        self.cut.take_if(|(_, until_ms)| self.now_ms >= *until_ms);
        if self.cut.is_none() && random.below(50) == 0 {
            let robot = random.below(self.robots.len() as u64) as usize;
            self.cut = Some((robot, self.now_ms + 5_000 + random.below(7_000)));
            self.tally.cuts += 1;
        }
    }

    fn is_cut_off(&self, message: &Message) -> bool {
        let id = match message {
            Message::ToMediator(report) => &report.robot_id,
            Message::ToRobot(message) => &message.robot_id,
        };
        self.cut
            .is_some_and(|(robot, _)| self.robots[robot].id == *id)
    }

    /// An operator sees no body in an area, and says so. He knows nothing of grants.
    fn clear_what_is_empty(&mut self, random: &mut Random) {
        if random.below(4) != 0 {
            return;
        }
        let area = random.below(self.floor.limits.len() as u64) as usize;
        let is_empty =
            { self.robots.iter() }.all(|robot| !robot.stands_in(&self.floor).contains(&area));
        if let Some(manager) = self.manager.as_mut().filter(|_| is_empty) {
            let now_ns = self.now_ms * 1_000_000;
            match manager.clear(self.floor.name(area), true, now_ns) {
                Ok(of) => self.tally.cleared += u64::from(!of.is_empty()),
                Err(ClearError::MayEnter { .. }) => self.tally.not_yet_cleared += 1,
                Err(_) => {}
            }
        }
    }

    fn crash_manager(&mut self, faults: Faults, random: &mut Random) {
        if let Some(manager) = self.manager.take() {
            self.tally.add_manager(&manager.counters());
        }
        self.manager_restart_ms = self.now_ms + random.below(3_000);
        self.tally.mediator_crashes += 1;
        if faults.power && random.chance(30) {
            self.tally.writes_lost += self.journal.lose_power(random);
            self.tally.power_losses += 1;
        }
        match self.broken {
            Some(Broken::ForgetsJournal) => self.journal.forget(Left::Epoch),
            Some(Broken::ForgetsEpoch) => self.journal.forget(Left::Nothing),
            Some(Broken::AwaitsNobody) => self.journal.forget(Left::Absence),
            _ => {}
        }
        if faults.journal && random.chance(50) {
            self.journal.lose(random);
            self.tally.journals_lost += 1;
        }
    }

    fn start_whoever_is_due(&mut self, random: &mut Random) {
        for robot in &mut self.robots {
            if robot.process.is_none() && self.now_ms >= robot.restart_ms {
                let client = Client::new(&robot.id, &self.floor.setup.site, random.next() | 1);
                let client = client.on(self.floor.setup.floor.clone());
                robot.process = Some(Process::new(client));
                robot.until_ms = self.now_ms + random.below(500);
            }
        }
        if self.manager.is_none() && self.now_ms >= self.manager_restart_ms {
            let stored = self.journal.read();
            let plans = self.floor.plans.clone();
            let now_ns = self.now_ms * 1_000_000;
            let is_first = self.now_ms <= BEGINS_MS + STEP_MS;
            let start_ns = if is_first { 0 } else { now_ns };
            let manager = Manager::with_plans(&self.floor.setup, plans, stored, start_ns);
            let mut manager = manager.expect("its own journal").speaks_as(self.now_ms | 1);
            for listed in &self.floor.setup.robots {
                if !self.robots.iter().any(|robot| robot.id == listed.id) {
                    manager.absent(&listed.id, now_ns).expect("nobody hears it");
                }
            }
            // Nothing is told before the new epoch is on the disk.
            self.journal.write(manager.entries().collect());
            self.journal.keep();
            self.manager = Some(manager);
        }
    }

    fn deliver(&mut self, faults: Faults, random: &mut Random) {
        let now_ms = self.now_ms;
        let (due, later): (Vec<_>, Vec<_>) = std::mem::take(&mut self.network)
            .into_iter()
            .partition(|(at_ms, _)| *at_ms <= now_ms);
        self.network = later;
        let due = due.into_iter().map(|(_, message)| message);
        let mut due: Vec<Message> = due.filter(|message| !self.is_cut_off(message)).collect();
        if faults.replays && !self.past.is_empty() && random.chance(5) {
            due.push(self.past[random.below(self.past.len() as u64) as usize].clone());
            self.tally.replayed += 1;
        }
        for message in due {
            match message {
                Message::ToMediator(report) => self.step_manager(Some(&report), faults, random),
                Message::ToRobot(message) => {
                    let mut robots = self.robots.iter_mut().enumerate();
                    let robot = robots.find(|(_, robot)| robot.id == message.robot_id);
                    let Some((number, robot)) = robot else {
                        continue;
                    };
                    if let Some(second) = self.second.as_mut().filter(|own| own.robot == number) {
                        second.receive(&message, now_ms);
                    }
                    if let Some(process) = &mut robot.process {
                        process.client.receive(&message, now_ms * 1_000_000);
                    }
                }
            }
        }
    }

    fn send(&mut self, message: Message, faults: Faults, random: &mut Random) {
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
        for _ in 0..copies {
            let delay_ms = if random.chance(20) {
                random.below(LATEST_MS)
            } else {
                random.below(40)
            };
            self.network.push((self.now_ms + delay_ms, message.clone()));
        }
    }

    fn drive(&mut self, random: &mut Random) {
        let now_ms = self.now_ms;
        let (first, lay_by) = (self.floor.first, self.floor.lay_by);
        for index in 0..self.robots.len() {
            let was = self.robots[index].spot;
            self.robots[index].drive(&self.floor, now_ms, random);
            let robot = &self.robots[index];
            let entered_first = robot.spot != was && Some(robot.spot) == first;
            let acquired = { robot.process.as_ref() }.is_some_and(|own| own.client.is_acquired());
            if robot.role == "emergency" && entered_first && acquired {
                // Judged by the bodies: the robot that it passes stands completely aside.
                let aside = self.robots.iter().any(|other| {
                    other.role == "normal" && Some(other.spot) == lay_by && other.crossing.is_none()
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
                    } else if self.tally.power_losses + self.tally.journals_lost == 0
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
            self.send(Message::ToMediator(report), faults, random);
        }
    }

    /// Somebody switches on a second process of a robot, which ends again.
    fn step_second(&mut self, faults: Faults, random: &mut Random) {
        let now_ms = self.now_ms;
        self.second.take_if(|own| own.is_over(now_ms));
        if faults.seconds && self.second.is_none() && random.below(100) == 0 {
            let number = random.below(self.robots.len() as u64) as usize;
            let robot = &self.robots[number];
            let registered =
                { robot.process.as_ref() }.is_some_and(|own| own.client.is_registered());
            if registered {
                let second = Second::start(number, &robot.id, &self.floor, now_ms, random);
                self.second = Some(second);
                self.tally.seconds += 1;
            }
        }
        if let Some(second) = &mut self.second {
            second.assert_has_nothing(&self.floor);
            if let Some(report) = second.step(now_ms) {
                self.send(Message::ToMediator(report), faults, random);
            }
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
        let asked = self.tally.journals_lost > 0;
        let lost = asked || self.tally.power_losses > 0;
        for alarm in manager.alarms() {
            match alarm {
                Alarm::Silent { .. }
                | Alarm::Back { .. }
                | Alarm::Still { .. }
                | Alarm::Mute { .. } => {}
                // Of reports with levels of long ago.
                Alarm::BadReport {
                    what: BadReport::Fence { .. },
                    ..
                } if self.now_ms < self.replays_until_ms => self.tally.refused += 1,
                Alarm::Doubled { .. } if self.tally.seconds > 0 => self.tally.doubled += 1,
                Alarm::Preempted { .. } => self.tally.preempted += 1,
                Alarm::Forgotten { .. } if lost => self.tally.forgotten += 1,
                Alarm::Bypassed { .. } if lost => self.tally.bypassed += 1,
                Alarm::Adopted { .. } if lost => self.tally.adopted += 1,
                // Reports of long ago tell of mediators that are gone.
                Alarm::SecondMediator { .. } if asked => {}
                Alarm::OlderJournal { .. } | Alarm::GoesOn { .. } if asked => {
                    self.tally.asked += 1;
                }
                alarm => self
                    .accusations
                    .push(format!("{} ms: {alarm}", self.now_ms)),
            }
        }
        let mut messages = Vec::new();
        while let Some(message) = manager.next_message(now_ns) {
            messages.push(message);
        }
        for entry in &entries {
            match entry {
                Entry::Number(_) => self.tally.coordinations += 1,
                Entry::Coordination { record: None, .. } => self.tally.finished += 1,
                _ => {}
            }
        }
        let mut stop = None;
        if !entries.is_empty() {
            let planned = self.stop.take_if(|(write, _)| *write == self.writes);
            self.writes += 1;
            let random_stop = (faults.crashes && random.below(40) == 0)
                .then(|| Point::ALL[random.below(4) as usize]);
            stop = planned.map(|(_, point)| point).or(random_stop);
        }
        match stop {
            Some(Point::BeforeJournal) => {
                self.tally.before_journal += 1;
                if self.broken == Some(Broken::TellsFirst) {
                    for message in messages {
                        self.send(Message::ToRobot(message), faults, random);
                    }
                }
                // Nobody hears of it.
                return self.crash_manager(faults, random);
            }
            Some(Point::AfterJournal) => {
                self.tally.after_journal += 1;
                messages.clear();
            }
            Some(Point::AmidMessages) => {
                self.tally.amid_messages += 1;
                messages.truncate(messages.len() / 2);
            }
            Some(Point::AfterMessages) => self.tally.after_messages += 1,
            None => {}
        }
        self.journal.write(entries);
        for message in messages {
            self.send(Message::ToRobot(message), faults, random);
        }
        if stop.is_some() {
            self.crash_manager(faults, random);
        }
    }

    /// Judges by where the bodies are, not by what anybody says.
    fn judge(&self) {
        let mut inside: BTreeMap<usize, Vec<&str>> = BTreeMap::new();
        for robot in &self.robots {
            for area in robot.stands_in(&self.floor) {
                inside.entry(area).or_default().push(&robot.id);
            }
        }
        for (area, robots) in inside {
            let capacity = self.floor.limits[area];
            assert!(
                robots.len() <= capacity as usize,
                "seed {}, {} ms: area {} holds {capacity}, and {robots:?} are in it: {}",
                self.seed,
                self.now_ms,
                self.floor.name(area),
                self.explain()
            );
        }
    }
}

/// A new report with levels and fences of long ago, as from a part of the robot that has fallen behind.
fn stale(client: &mut Client, past: &[Message], random: &mut Random) -> Option<RobotReport> {
    let Message::ToMediator(old) = past.get(random.below(100) as usize)? else {
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
