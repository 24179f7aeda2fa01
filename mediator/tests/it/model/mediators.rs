//! One mediator, or two at once: their journals, their stops at any point of a step, and what they tell people.

use super::fleet::{BEGINS_MS, Broken, Faults, Fleet, LATEST_MS, Message, Point, STEP_MS};
use super::floor::Floor;
use super::journal::{Journal, Left};
use super::robot::Robot;
use super::second::Second;
use crate::random::Random;
use contract::wire::RobotReport;
use mediator::journal::Entry;
use mediator::manager::{Alarm, BadReport, Manager};

pub struct Mediator {
    /// While it runs.
    pub manager: Option<Manager>,
    pub journal: Journal,
    /// When it starts again.
    pub restart_ms: u64,
    /// Robots that the site lists and nobody has. Its operator has yet to say so, again after each time that all are asked.
    unsaid: Vec<String>,
}

impl Mediator {
    pub fn new(journal: Journal, starts_ms: u64) -> Self {
        Self {
            manager: None,
            journal,
            restart_ms: starts_ms,
            unsaid: Vec::new(),
        }
    }
}

/// Robots that the site lists and nobody has.
fn not_there(floor: &Floor, robots: &[Robot]) -> Vec<String> {
    let nobody_has = |id: &String| !robots.iter().any(|robot| robot.id == *id);
    let listed = floor.setup.robots.iter().map(|own| own.id.clone());
    listed.filter(nobody_has).collect()
}

impl Fleet {
    /// Somebody switches on a second mediator, and off again.
    pub fn keep_a_spare(&mut self, wanted: bool, random: &mut Random) {
        if self.spare_stays {
            return;
        }
        let two = self.mediators.len() == 2;
        if two && (!wanted || random.below(500) == 0) {
            let spare = self.mediators.pop();
            if let Some(manager) = spare.and_then(|own| own.manager) {
                self.tally.add_manager(&manager.counters());
            }
        } else if wanted && !two && random.below(100) == 0 {
            self.tally.spares += 1;
            // The other one was told nothing.
            self.closed.clear();
            let journal = Journal::of(1000 * self.tally.spares);
            self.mediators.push(Mediator::new(journal, self.now_ms));
        }
    }

    pub fn start_mediator_if_due(&mut self, number: usize) {
        let now_ms = self.now_ms;
        let mediator = &mut self.mediators[number];
        if let Some(manager) = &mut mediator.manager {
            let refused = |id: &String| manager.absent(id, true, now_ms * 1_000_000).is_err();
            mediator.unsaid.retain(refused);
        }
        if mediator.manager.is_some() || now_ms < mediator.restart_ms {
            return;
        }
        let plans = self.floor.plans.clone();
        let now_ns = now_ms * 1_000_000;
        let is_first = now_ms <= BEGINS_MS + STEP_MS;
        let waits = !is_first && self.broken != Some(Broken::AwaitsNobody);
        let start_ns = if waits { now_ns } else { 0 };
        let stored = mediator.journal.read();
        let manager = Manager::with_plans(&self.floor.setup, plans, stored, start_ns);
        let instance = now_ms * 2 + number as u64 + 1;
        let mut manager = manager.expect("its own journal").speaks_as(instance);
        mediator.unsaid = not_there(&self.floor, &self.robots);
        if !waits {
            let refused = |id: &String| manager.absent(id, true, now_ns).is_err();
            mediator.unsaid.retain(refused);
        }
        // Nothing is told before the new epoch is on the disk.
        mediator.journal.write(manager.entries().collect());
        mediator.journal.keep();
        mediator.manager = Some(manager);
        // Nobody waits for second processes, so until a mediator has heard of one its body is in nobody's way. They are heard at once here.
        self.seconds.iter_mut().for_each(|own| own.report_ms = 0);
        if self.is_recovered {
            self.open_all();
        }
    }

    pub fn crash_mediator(&mut self, number: usize, faults: Faults, random: &mut Random) {
        self.seconds.iter_mut().for_each(Second::tells_anew);
        let is_alone = self.mediators.len() == 1;
        let mediator = &mut self.mediators[number];
        if let Some(manager) = mediator.manager.take() {
            self.tally.add_manager(&manager.counters());
        }
        mediator.restart_ms = self.now_ms + random.below(3_000);
        self.tally.mediator_crashes += 1;
        let journal = &mut mediator.journal;
        if faults.power && random.chance(30) {
            self.tally.writes_lost += journal.lose_power(random);
            self.tally.power_losses += 1;
        }
        if faults.journal && random.chance(50) {
            journal.lose(random);
            self.tally.journals_lost += 1;
        }
        // It may not have written yet what it was just told; and where there are two, the other one was told nothing.
        let has_closed = |area| is_alone && journal.has_closed(self.floor.name(area));
        self.closed.retain(|&area, _| has_closed(area));
        match self.broken {
            Some(Broken::ForgetsJournal) => journal.forget(Left::Epoch),
            Some(Broken::ForgetsEpoch) => journal.forget(Left::Nothing),
            Some(Broken::AwaitsNobody) => journal.forget(Left::Absence),
            Some(Broken::ForgetsClosed) => journal.forget_what_is_closed(),
            _ => {}
        }
    }

    /// Hands the manager a report, or lets time pass; then journal, then network, with a crash at any point between.
    pub fn step_mediator(
        &mut self,
        number: usize,
        report: Option<&RobotReport>,
        faults: Faults,
        random: &mut Random,
    ) {
        let now_ns = self.now_ms * 1_000_000;
        // A spare one may be gone.
        let mediator = self.mediators.get_mut(number);
        let Some(manager) = mediator.and_then(|own| own.manager.as_mut()) else {
            return;
        };
        let stood_by = manager.stands_by();
        match report {
            Some(report)
                if self.broken == Some(Broken::NeverStandsBy)
                    && report.mediator_instance != manager.instance() =>
            {
                let gone = RobotReport {
                    mediator_heard: false,
                    ..report.clone()
                };
                manager.report(&gone, now_ns);
            }
            Some(report) => manager.report(report, now_ns),
            None => manager.tick(now_ns),
        }
        let turns = stood_by != manager.stands_by();
        let entries: Vec<_> = manager.entries().collect();
        let alarms: Vec<_> = manager.alarms().collect();
        let mut messages: Vec<_> = std::iter::from_fn(|| manager.next_message(now_ns)).collect();
        if self.broken == Some(Broken::NeverRevokes) {
            messages.iter_mut().for_each(|own| own.revocations.clear());
        }
        if turns {
            // Whoever goes on now was told nothing.
            self.closed.clear();
            if self.is_recovered {
                self.open_all();
            }
        }
        let asks =
            |alarm: &Alarm| matches!(alarm, Alarm::OlderJournal { .. } | Alarm::GoesOn { .. });
        if alarms.iter().any(asks) {
            self.mediators[number].unsaid = not_there(&self.floor, &self.robots);
        }
        alarms.into_iter().for_each(|alarm| self.tell_people(alarm));
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
            let random_stop = (faults.crashes && random.below(faults.stops_at) == 0)
                .then(|| Point::ALL[random.below(4) as usize]);
            stop = planned.map(|(_, point)| point).or(random_stop);
        }
        match stop {
            Some(Point::BeforeJournal) => {
                self.tally.before_journal += 1;
                if self.broken == Some(Broken::TellsFirst) {
                    for message in messages {
                        self.send(Message::ToRobot(number, message), faults, random);
                    }
                }
                // Nobody hears of it.
                return self.crash_mediator(number, faults, random);
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
        self.mediators[number].journal.write(entries);
        for message in messages {
            self.send(Message::ToRobot(number, message), faults, random);
        }
        if stop.is_some() {
            self.crash_mediator(number, faults, random);
        }
    }

    /// While this coordination ran, a robot of it was lost or out of reach, and so stood wherever it was; or somebody was where
    /// nobody knew of; or one has only just begun to hear again what it is to do.
    fn could_not_get_out_of_the_way(&self, named: &str) -> bool {
        let now_ns = self.now_ms * 1_000_000;
        let managers = { self.mediators.iter() }.filter_map(|own| own.manager.as_ref());
        let mut all = managers.flat_map(|manager| manager.status(now_ns).coordinations);
        let own = all.find(|own| named == format!("{}/{}", own.id, own.number));
        own.is_some_and(|own| {
            let begun_ms = self.now_ms.saturating_sub(own.age_ms);
            let mut robots = self.robots.iter();
            self.second_ms >= begun_ms
                || robots.any(|robot| {
                    let plays = own.robots.iter().any(|(_, id)| *id == robot.id);
                    let is_deaf = robot.deaf_ms + LATEST_MS >= self.now_ms;
                    plays && (robot.lost_ms >= begun_ms || is_deaf)
                        || robot.elsewhere_ms >= begun_ms
                })
        })
    }

    /// What people are told must be true.
    fn tell_people(&mut self, alarm: Alarm) {
        let tally = &mut self.tally;
        // Whoever follows another mediator than before brings what that one has granted.
        let asked = tally.journals_lost + tally.spares > 0;
        let lost = asked || tally.power_losses > 0;
        let ordered = tally.orders > 0;
        // A late report still says where a robot was before it was carried away.
        let elsewhere = tally.mistaken + tally.taken_away > 0;
        match alarm {
            Alarm::Silent { .. }
            | Alarm::Back { .. }
            | Alarm::NotAwaited { .. }
            | Alarm::Still { .. }
            | Alarm::Mute { .. } => {}
            // Of reports with levels of long ago.
            Alarm::BadReport {
                what: BadReport::Fence { .. },
                ..
            } if self.now_ms < self.replays_until_ms => tally.refused += 1,
            Alarm::Doubled { .. } if tally.seconds > 0 => tally.doubled += 1,
            // Who is lost says nothing of whoever was before it in an area that it gives back.
            Alarm::SilentSecond { .. }
                if tally.seconds + tally.started_elsewhere + tally.lost > 0 => {}
            // It was carried, was given a wrong pose, or had driven on by what a journal has lost.
            Alarm::StartedElsewhere { .. } if lost || elsewhere => tally.started_elsewhere += 1,
            Alarm::Floor { .. } if tally.others_floor > 0 => {}
            Alarm::Preempted { .. } => tally.preempted += 1,
            Alarm::Forgotten { .. } if lost || ordered => tally.forgotten += 1,
            Alarm::Bypassed { .. } if lost || ordered || elsewhere || tally.seconds > 0 => {
                tally.bypassed += 1
            }
            Alarm::BypassedBySecond { .. }
                if tally.robot_crashes + tally.seconds + tally.started_elsewhere > 0 =>
            {
                tally.bypassed += 1
            }
            Alarm::Adopted { .. } | Alarm::TakenOver { .. } if lost => tally.adopted += 1,
            Alarm::Void { .. } if lost && ordered => tally.void += 1,
            // Reports of long ago tell of mediators that are gone.
            Alarm::SecondMediator { .. } if asked => {}
            Alarm::OlderJournal { .. } | Alarm::GoesOn { .. } if asked => tally.asked += 1,
            Alarm::Intruder { .. } | Alarm::Overfull { .. } if elsewhere => tally.intruders += 1,
            // The journal has lost who gave an area back, and who has it now; neither process knows.
            Alarm::Overfull { .. } if lost => {}
            // Of robots that ask for what they do not need, while something hinders them.
            Alarm::Circle { .. } if elsewhere || tally.cuts + tally.lost > 0 => {}
            // An area that was closed for good may be the one that robots get out of the way to.
            Alarm::LetGo { .. } if ordered => {}
            Alarm::LetGo { ref coordination }
                if self.could_not_get_out_of_the_way(coordination) =>
            {
                self.tally.let_go += 1;
            }
            alarm => self
                .accusations
                .push(format!("{} ms: {alarm}", self.now_ms)),
        }
    }
}
