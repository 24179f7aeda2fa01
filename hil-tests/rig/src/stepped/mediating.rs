//! The mediator's part of a step, and the ends of its process: between two steps, or while it writes its journal.

use contract::Message as _;
use onboard::cli::Failure;
use sim::world::Random;

use super::disk::{Disk, End};
use super::fleet::Stepped;
use super::mediator::{Ending, HeldUp, SteppedMediator};
use super::message::{Message, MessageKind};
use crate::scenario::ScriptedKind;

/// While it has nothing to write for so long, it ends between two steps.
const WRITES_WITHIN_NS: u64 = 1_000_000_000;
/// It ends during one of so many operations on its disk, of which a transaction takes a few.
const OPERATIONS: f64 = 12.0;
/// Which one, and what a loss of power leaves of what was not synced.
const END_STREAM: u64 = 0x454E_4453;

impl Stepped<'_> {
    /// Both mediators go on, and what they say leaves.
    pub(super) fn step_mediator(&mut self, now_ns: u64) -> Result<(), Failure> {
        let (mut answers, mut second_answers) = (Vec::new(), Vec::new());
        let full = self.faults.lasts(ScriptedKind::FullDisk, None);
        self.disk.fill(full);
        let held_up = HeldUp {
            disk_ns: self.faults.disk_ns(),
            hangs: false,
        };
        let hangs = self.faults.lasts(ScriptedKind::HangMediator, None);
        let first = { self.mediator.iter_mut() }.map(|own| (own, HeldUp { hangs, ..held_up }));
        for (mediator, held_up) in first {
            mediator.cycle(now_ns, held_up, |answer| answers.push(answer))?;
        }
        if self.has_ended(now_ns) {
            // What it wrote last nobody has heard of.
            answers.clear();
        }
        let second = { self.second_mediator.iter_mut() }.map(|own| (own, held_up));
        for (mediator, held_up) in second {
            mediator.cycle(now_ns, held_up, |answer| second_answers.push(answer))?;
        }
        let status = self
            .mediator
            .as_mut()
            .and_then(SteppedMediator::take_status);
        if let Some(status) = status {
            self.close_or_open(&status);
            self.told.take(status, now_ns);
        }
        // Before what follows from it is heard.
        self.note_cleared(now_ns);
        let answers = answers.into_iter().map(|own| (MessageKind::Answer, own));
        let second_answers =
            { second_answers.into_iter() }.map(|own| (MessageKind::SecondAnswer, own));
        for (kind, answer) in answers.chain(second_answers) {
            let robot = { self.robots.iter() }.position(|member| member.id == answer.robot_id);
            if let Some(robot) = robot {
                let message = Message {
                    robot,
                    kind,
                    bytes: answer.encode_to_vec(),
                };
                self.send(message, now_ns);
            }
        }
        Ok(())
    }

    /// From now on the mediator's process ends while it writes its journal next.
    pub(super) fn end_mediator(&mut self, by_power: bool, now_ns: u64) {
        let mut random = Random::new(self.world.lock().seed() ^ now_ns, END_STREAM);
        let after = (random.unit() * OPERATIONS) as u32;
        let how = if by_power {
            End::PowerLost(random)
        } else {
            End::Killed
        };
        self.disk.cut(after, how);
        let until_ns = now_ns + WRITES_WITHIN_NS;
        self.ending = Some(Ending { by_power, until_ns });
    }

    /// Whether the mediator's process has come to its end, if it was to.
    fn has_ended(&mut self, now_ns: u64) -> bool {
        let Some(ending) = self.ending else {
            return false;
        };
        let is_late = now_ns >= ending.until_ns;
        let left = { self.disk.left() }.or_else(|| is_late.then(|| self.left_between(ending)));
        let ends = left.is_some();
        if let Some(disk) = left {
            self.kill_mediator(disk, now_ns);
        }
        ends
    }

    /// What its end leaves between two steps.
    fn left_between(&self, ending: Ending) -> Disk {
        if ending.by_power {
            self.disk.synced()
        } else {
            // What it has not written by now is gone.
            self.disk.copy()
        }
    }

    pub(super) fn kill_mediator(&mut self, disk: Disk, now_ns: u64) {
        self.disk = disk;
        self.ending = None;
        let killed = self.mediator.take();
        self.dropped += killed.map_or(0, |own| own.dropped());
        if let Some((_, end_ns)) = self.mediator_spans_ns.last_mut() {
            end_ns.get_or_insert(now_ns);
        }
    }

    /// Starts the mediator with the journal on its disk, unless it runs, or another fault keeps it from that: of two the longer one
    /// counts.
    pub(super) fn start_mediator(&mut self, now_ns: u64) -> Result<(), Failure> {
        if let Some(ending) = self.ending {
            self.kill_mediator(self.left_between(ending), now_ns);
        }
        let kept_down = [
            ScriptedKind::KillMediator,
            ScriptedKind::RebootMediator,
            ScriptedKind::LoseJournal,
            ScriptedKind::FullDisk,
        ]
        .into_iter()
        .any(|what| self.faults.lasts(what, None));
        let plan = self.plans.mediator.as_ref();
        if let Some(plan) = plan.filter(|_| self.mediator.is_none() && !kept_down) {
            let mut mediator = SteppedMediator::start(plan, self.disk.clone(), now_ns)?;
            mediator.drift(self.faults.drift(None));
            self.mediator = Some(mediator);
            self.mediator_spans_ns.push((now_ns, None));
        }
        Ok(())
    }
}
