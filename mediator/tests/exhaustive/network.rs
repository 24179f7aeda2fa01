//! Time passes, reports and messages arrive.

use std::hash::Hash;

use contract::wire::MediatorReport;
use contract::wire::RobotReport;
use mediator::journal::Entry;
use mediator::manager::Manager;

use super::action::{AREAS, Fate};
use super::kept::Kept;
use super::rules::{AFTER_ALL_NS, Rule};
use super::world::{Message, World, now_ns};

impl World {
    pub(super) fn pass(&mut self) {
        self.tick += 1;
        let tick = self.tick;
        self.robots.iter_mut().for_each(|robot| robot.pass(tick));
        let without = self.limits.without;
        let ((), messages) = self.manage("tick", |manager, now_ns| {
            manager.tick(now_ns);
            if without == Some(Rule::SilenceBlocks) {
                for id in ["one", "two"] {
                    // Whoever is heard keeps what it has.
                    let _ = manager.absent(id, true, now_ns + AFTER_ALL_NS);
                }
            }
        });
        self.deliver(messages);
    }

    pub(super) fn talk(&mut self, robot: usize, fate: Fate) {
        let tick = self.tick;
        let Some(mut report) = self.robots[robot].report(tick) else {
            return;
        };
        if fate == Fate::OldFence {
            report.change(|report| {
                for access in report.access.iter_mut().filter(|access| access.fence > 0) {
                    if let Some(level) = &mut access.level {
                        // Path 0 ends with `released`.
                        (level.path, level.progress) = (0, 4);
                        access.fence -= 1;
                    }
                }
            });
        }
        if matches!(fate, Fate::ReportLate | Fate::ReportTwice) {
            self.late = Some(Message::Report(report.clone()));
        }
        if fate == Fate::ReportLate {
            return;
        }
        if report.get().session > 0 {
            let said = |area: &&str| report.get().stands_in.iter().any(|own| own == *area);
            let areas = AREAS.iter().enumerate().filter(|(_, area)| said(area));
            self.robots[robot].said_in = areas.fold(0, |bits, (area, _)| bits | 1 << area);
        }
        let mut messages = self.hear(report);
        if matches!(fate, Fate::AnswerLate | Fate::AnswerTwice) {
            let id = self.robots[robot].id();
            let answer = messages
                .iter()
                .rev()
                .find(|message| message.get().robot_id == id);
            let number = self.robots[robot].number;
            self.late = answer.map(|answer| Message::Answer(number, answer.clone()));
            if fate == Fate::AnswerLate {
                messages.retain(|message| message.get().robot_id != id);
            }
        }
        self.deliver(messages);
    }

    /// What was held back.
    pub(super) fn arrive(&mut self) {
        let Some(late) = self.late.take() else { return };
        match late {
            Message::Report(mut report) => {
                let stored = &self.journal.get().stored;
                if self.limits.without == Some(Rule::Session)
                    && let Some(own) = stored.robots.get(&report.get().robot_id)
                {
                    report.change(|report| {
                        report.session = own.session;
                        report.boot_epoch = own.boot_epoch;
                        report.mediator_epoch = self.manager.get().epoch();
                        report.mediator_instance = u64::from(self.starts);
                        report.mediator_journal = stored.journal;
                    });
                }
                let messages = self.hear(report);
                self.deliver(messages);
            }
            Message::Answer(robot, mut answer) => {
                let robot = usize::from(robot);
                if self.limits.without == Some(Rule::Epoch)
                    && let Some(client) = &self.robots[robot].client
                {
                    answer.change(|answer| {
                        answer.mediator_epoch = client.get().mediator_epoch();
                        answer.sequence = 1 << 40;
                        answer.instance = u64::from(self.starts);
                        answer.session = client.get().session();
                    });
                }
                self.receive(robot, &answer);
            }
        }
    }

    /// The mediator takes in a report.
    pub(super) fn hear(&mut self, mut report: Kept<RobotReport>) -> Vec<Kept<MediatorReport>> {
        let stored = &self.journal.get().stored;
        let mut later_ns = 0;
        match self.limits.without {
            Some(Rule::Adopted) => {
                let last = |area: &String| stored.fences.get(area).copied().unwrap_or(0);
                report.change(|report| {
                    report
                        .access
                        .retain(|access| access.fence <= last(&access.area));
                });
            }
            Some(Rule::Fence) => report.change(|report| {
                for access in report.access.iter_mut() {
                    let place = (report.robot_id.clone(), access.area.clone());
                    let known = stored.access.get(&place).map_or(0, |own| own.fence);
                    access.fence = if known > 0 { known } else { access.fence };
                }
            }),
            Some(Rule::OneProcess) => {
                let report = report.get();
                let known = stored.robots.get(&report.robot_id);
                if known.is_some_and(|own| own.session > 0 && own.boot_epoch != report.boot_epoch) {
                    later_ns = AFTER_ALL_NS;
                }
            }
            _ => {}
        }
        let what = ("report", report.key(), later_ns);
        let report = report.get();
        let act = |manager: &mut Manager, now_ns| manager.report(report, now_ns + later_ns);
        self.manage(what, act).1
    }

    /// Lets the mediator do `what` it is told: first the journal, then messages. Returns what `act` does, too.
    pub(super) fn manage<R: Clone + Send + Sync + 'static>(
        &mut self,
        what: impl Hash,
        act: impl FnOnce(&mut Manager, u64) -> R,
    ) -> (R, Vec<Kept<MediatorReport>>) {
        let now_ns = now_ns(self.tick);
        let what = (what, now_ns, self.limits.without.map(|rule| rule as u8));
        let (result, entries, messages) = self.manager.change_by(what, |manager| {
            let result = act(manager, now_ns);
            let entries: Vec<Entry> = manager.entries().collect();
            drop(manager.alarms());
            let messages = std::iter::from_fn(|| manager.next_message(now_ns));
            let messages = messages.map(|mut message| {
                for grant in &mut message.access {
                    // For people.
                    grant.waits_for.clear();
                }
                Kept::new(message)
            });
            (result, Kept::new(entries), messages.collect::<Vec<_>>())
        });
        if !entries.get().is_empty() {
            self.journal
                .change_by(("writes", entries.key()), |journal| {
                    journal.before = Some(journal.stored.clone());
                    let entries = entries.get().iter().cloned();
                    entries.for_each(|entry| journal.stored.apply(entry));
                });
        }
        (result, messages)
    }

    pub(super) fn deliver(&mut self, messages: Vec<Kept<MediatorReport>>) {
        for message in messages {
            for robot in 0..self.robots.len() {
                let id = &message.get().robot_id;
                if self.robots[robot].id() == id && !self.robots[robot].is_cut {
                    self.receive(robot, &message);
                }
            }
        }
    }

    pub(super) fn receive(&mut self, robot: usize, message: &Kept<MediatorReport>) {
        let own = &mut self.robots[robot];
        let now_ns = own.now_ns(self.tick);
        if let Some(client) = &mut own.client {
            client.change_by(("receives", message.key(), now_ns), |client| {
                client.receive(message.get(), now_ns)
            });
        }
    }
}
