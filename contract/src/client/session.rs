//! The robot's session: its identity, its registration with a start of the mediator, and which messages are stale.

use std::collections::VecDeque;

use super::others::{Before, Other};
use crate::floor::Floor;
use crate::timing::{DOUBLED_AFTER_NS, LEASE_NS, LISTENS_FIRST_NS, SILENT_AFTER_NS};
use crate::wire::{Factsheet, MediatorReport, RobotReport, TakeUp};
use crate::{VERSION, Version};

/// What became of a message of the mediator.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Received {
    /// Taken in.
    News,
    /// The robot was registered by it: levels were taken over.
    Registered,
    /// From the past, or for another boot of this robot.
    Stale,
    /// The mediator does not want this robot; [`refusal`](super::Client::refusal) says why.
    Refused,
    /// Of another mediator than the one that the robot follows.
    Other,
    /// The mediator speaks another version.
    Version,
    /// Its numbers are none that a mediator has.
    Nonsense,
}

/// Numbers of the protocols.
const AREAS: u32 = 1;
const CONTROL: u32 = 2;

/// Reports that may still give a lease. More are sent only when far more happens than on any floor; the oldest then gives none.
const SENT: usize = 256;

/// No mediator has a larger epoch or sequence: what says so is nonsense.
pub const LAST_NUMBER: u64 = 1 << 62;
/// The mediator that a robot follows does not raise its epoch by more at once, nor does one that goes on with its journal.
pub const EPOCH_STEP: u64 = 1 << 20;
/// Beyond half of [`LAST_NUMBER`] nobody is believed to have sent so many reports more than before: one lie leaves room for those that
/// follow.
pub const SEQUENCE_STEP: u64 = 1 << 20;

/// The robot's identity and its registration with a mediator.
#[derive(Clone, Debug)]
pub(super) struct Session {
    robot_id: String,
    site: String,
    pub(super) floor: Floor,
    /// It knows no protocol 2.
    pub(super) without_control: bool,
    pub(super) factsheet: Option<Factsheet>,
    boot_epoch: u64,
    /// Of the last report.
    sequence: u64,
    /// Of the last step.
    now_ns: u64,
    /// Reports within the last [`LEASE_NS`]: sequence, and the step before them.
    sent: VecDeque<(u64, u64)>,
    /// When the newest report was sent that the mediator says it has.
    heard_by_ns: Option<u64>,
    /// Of the newest report that the mediator which is followed says it has.
    acknowledged: u64,
    /// Reports from that one on were for who is followed now, of a robot that knew where it was.
    counts_from: u64,
    /// The mediator's process that the robot follows; 0 for none.
    instance: u64,
    /// Its journal; 0 for none.
    journal: u64,
    /// It grants nothing, since others follow another one.
    stands_by: bool,
    /// It was heard at the last step.
    hears: bool,
    other: Option<Other>,
    /// Until then it enters nothing that it was granted: it has just begun to listen.
    listens_until_ns: u64,
    /// Of the newest start of the mediator that was heard.
    pub(super) mediator_epoch: u64,
    /// Of its newest message.
    mediator_sequence: u64,
    /// Those that were followed before it.
    before: Before,
    /// The registration; 0 without one.
    pub(super) number: u64,
    /// When the mediator that is followed, or has refused the robot, was heard last.
    heard_ns: u64,
    pub(super) refusal: String,
    /// It is that another process speaks for this identity.
    pub(super) identity_taken: bool,
    /// Another process asks to speak for it.
    pub(super) identity_doubled: bool,
    pub(super) role: String,
    pub(super) take_up: Option<TakeUp>,
}

impl Session {
    pub(super) fn new(robot_id: &str, site: &str, boot_epoch: u64) -> Self {
        Self {
            robot_id: robot_id.to_owned(),
            site: site.to_owned(),
            floor: Floor::default(),
            without_control: false,
            factsheet: None,
            boot_epoch,
            sequence: 0,
            now_ns: 0,
            sent: VecDeque::new(),
            heard_by_ns: None,
            acknowledged: 0,
            counts_from: 0,
            instance: 0,
            journal: 0,
            stands_by: false,
            hears: false,
            other: None,
            listens_until_ns: 0,
            mediator_epoch: 0,
            mediator_sequence: 0,
            before: Before::default(),
            number: 0,
            heard_ns: 0,
            refusal: String::new(),
            identity_taken: false,
            identity_doubled: false,
            role: String::new(),
            take_up: None,
        }
    }

    /// Takes in the head of a message. Its levels count only for [`Received::News`] and [`Received::Registered`].
    pub(super) fn receive(&mut self, message: &MediatorReport, now_ns: u64) -> Received {
        let other = self.instance != 0 && message.instance != self.instance;
        let newest = if other {
            self.before.newest_of(message.instance)
        } else {
            (self.mediator_epoch, self.mediator_sequence)
        };
        let was_registered = self.is_registered();
        if message.robot_id != self.robot_id
            || message.boot_epoch != self.boot_epoch
            || (message.mediator_epoch, message.sequence) <= newest
        {
            return Received::Stale;
        }
        // Before its numbers, of which an older version has fewer.
        if VERSION.accept(Version::from(message.version)).is_err() {
            return Received::Version;
        }
        let follows = self.instance != 0 && !other;
        let takes_over = self.hears && self.is_its_journal(message.journal);
        let most = if follows || takes_over {
            self.mediator_epoch.saturating_add(EPOCH_STEP)
        } else {
            LAST_NUMBER
        };
        let nameless = message.instance == 0 || message.journal == 0;
        let beyond =
            message.mediator_epoch > most.min(LAST_NUMBER) || message.sequence > LAST_NUMBER;
        if nameless || beyond {
            return Received::Nonsense;
        }
        if message.stands_by && message.session == 0 {
            // Not to be followed, so its epoch means nothing.
            if other {
                self.note_other(message, now_ns);
            }
            if self.is_registered() {
                return Received::Other;
            }
            self.refusal.clone_from(&message.refusal);
            return Received::Refused;
        }
        if other {
            if !self.may_follow(message, now_ns) {
                self.note_other(message, now_ns);
                return Received::Other;
            }
            self.other = None;
            self.heard_by_ns = None;
            let newest = (self.mediator_epoch, self.mediator_sequence);
            self.before.add(self.instance, newest);
        }
        let registers = self.number != message.session;
        if other || registers || self.mediator_epoch != message.mediator_epoch {
            self.says_all();
        }
        self.instance = message.instance;
        self.journal = message.journal;
        self.heard_ns = now_ns;
        self.stands_by = message.stands_by;
        self.mediator_epoch = message.mediator_epoch;
        self.mediator_sequence = message.sequence;
        self.refusal.clone_from(&message.refusal);
        self.identity_taken = message.identity_taken;
        self.identity_doubled = message.identity_doubled;
        // A refusal says why; one that would take the robot in need not have noticed.
        let differs = self.floor.differs(message.floor_hash, &message.floor);
        if let Some(differs) = differs.as_ref().filter(|_| message.session != 0) {
            self.refusal = format!(
                "the mediator knows another floor: {differs}; give both the same site file"
            );
        }
        if message.session == 0 || differs.is_some() {
            self.number = 0;
            return Received::Refused;
        }
        self.hears = true;
        self.renew_lease(message.robot_sequence);
        self.role.clone_from(&message.role);
        if self.number == message.session {
            return Received::News;
        }
        self.number = message.session;
        if other && was_registered {
            // It need not know what the one before has granted: the robot keeps that, and tells it.
            return Received::News;
        }
        self.take_up.clone_from(&message.take_up);
        self.listens_until_ns = now_ns.saturating_add(LISTENS_FIRST_NS);
        Received::Registered
    }

    /// The mediator may know nothing of what was reported so far.
    fn says_all(&mut self) {
        self.counts_from = self.sequence + 1;
    }

    /// The newest report that the mediator has, if what rested in it need not be repeated.
    pub(super) fn known(&self) -> Option<u64> {
        Some(self.acknowledged).filter(|&heard| heard >= self.counts_from)
    }

    /// The mediator has this report, and perhaps none after it.
    fn renew_lease(&mut self, echoed: u64) {
        self.acknowledged = self.acknowledged.max(echoed.min(self.sequence));
        // Somebody has sent reports in its name: those that follow are to count.
        if echoed > self.sequence && is_reached_from(self.sequence, echoed) {
            self.sequence = echoed;
        }
        while let Some(&(sequence, sent_ns)) = self.sent.front()
            && sequence <= echoed
        {
            self.sent.pop_front();
            if sequence == echoed {
                self.heard_by_ns = Some(sent_ns);
            }
        }
    }

    /// The mediator had a report that was sent within [`LEASE_NS`], and it is the only one that may grant something, as far as the robot has
    /// heard since it was registered: two that do not hear of each other may grant the same.
    pub(super) fn has_lease(&self, now_ns: u64) -> bool {
        { self.heard_by_ns }.is_some_and(|sent_ns| now_ns <= sent_ns.saturating_add(LEASE_NS))
            && now_ns >= self.listens_until_ns
            && !self.other.is_some_and(|other| other.may_grant(now_ns))
    }

    /// Whether another mediator is followed. A robot without a registration takes the first that offers one; of the journal that it
    /// heard of last none of before, which has ended and counts on what this process has forgotten since. Else it must have
    /// started later than the present one, which must be gone: it is silent, or the other has its journal. One that stands by
    /// lets its robots go. A refusal of one with another journal ends no registration: it knows nothing of that, and the mediator
    /// that gave it, if it is heard again, would not know that the robot has forgotten what rests.
    fn may_follow(&self, message: &MediatorReport, now_ns: u64) -> bool {
        if message.stands_by {
            return false;
        }
        let silent = now_ns > self.heard_ns.saturating_add(SILENT_AFTER_NS);
        let as_late = message.mediator_epoch >= self.mediator_epoch;
        let later = message.mediator_epoch > self.mediator_epoch;
        let same_journal = self.is_its_journal(message.journal);
        if !self.is_registered() {
            return (as_late || !same_journal) && (message.session != 0 || silent);
        }
        let offers = message.session != 0;
        offers && (self.stands_by && as_late || later && silent) || later && same_journal
    }

    /// That of the mediator that it follows, or has followed last.
    fn is_its_journal(&self, journal: u64) -> bool {
        journal == self.journal
    }

    fn note_other(&mut self, message: &MediatorReport, now_ns: u64) {
        let known = { self.other }.filter(|own| own.is_heard(now_ns));
        // A late one of a process that has ended grants nothing any more.
        let has_ended =
            self.is_its_journal(message.journal) && message.mediator_epoch < self.mediator_epoch;
        let grants = !message.stands_by && !has_ended;
        self.other = Some(Other {
            since_ns: known.map_or(now_ns, |own| own.since_ns),
            heard_ns: now_ns,
            grants_ns: grants
                .then_some(now_ns)
                .or(known.and_then(|own| own.grants_ns)),
        });
    }

    /// Others speak to this robot for longer than a restart takes.
    pub(super) fn has_second_mediator(&self, now_ns: u64) -> bool {
        self.other.is_some_and(|other| {
            other.is_heard(now_ns)
                && other.heard_ns > other.since_ns.saturating_add(DOUBLED_AFTER_NS)
        })
    }

    /// Notes the time, and whether the mediator is heard. Returns whether that has changed.
    pub(super) fn listen(&mut self, now_ns: u64, silent_after_ns: u64) -> bool {
        self.now_ns = now_ns;
        let hears = !self.is_mediator_silent(now_ns, silent_after_ns);
        std::mem::replace(&mut self.hears, hears) != hears
    }

    /// By whom, and its number: two mediators of one epoch count alike.
    pub(super) fn registration(&self) -> (u64, u64) {
        (self.instance, self.number)
    }

    pub(super) fn is_registered(&self) -> bool {
        self.number != 0
    }

    pub(super) fn is_mediator_silent(&self, now_ns: u64, silent_after_ns: u64) -> bool {
        !self.is_registered() || now_ns > self.heard_ns.saturating_add(silent_after_ns)
    }

    /// The head of the next report, of a robot that knows where it is, or not.
    pub(super) fn next_report(&mut self, located: bool) -> RobotReport {
        if !located || !self.is_registered() {
            // What it says of areas need not count.
            self.says_all();
            self.counts_from += 1;
        }
        self.sequence += 1;
        let too_old = |sent_ns: u64| self.now_ns > sent_ns.saturating_add(LEASE_NS);
        while { self.sent.front() }.is_some_and(|&(_, sent_ns)| too_old(sent_ns))
            || self.sent.len() >= SENT
        {
            self.sent.pop_front();
        }
        self.sent.push_back((self.sequence, self.now_ns));
        RobotReport {
            version: Some(VERSION.into()),
            robot_id: self.robot_id.clone(),
            boot_epoch: self.boot_epoch,
            sequence: self.sequence,
            site: self.site.clone(),
            floor_hash: self.floor.hash(),
            without_control: self.without_control,
            floor: if self.is_registered() {
                Vec::new()
            } else {
                self.floor.say()
            },
            factsheet: { self.factsheet.as_ref() }
                .filter(|_| self.known().is_none())
                .map(|own| self.tell_protocols(own)),
            mediator_epoch: self.mediator_epoch,
            mediator_sequence: self.mediator_sequence,
            mediator_instance: self.instance,
            mediator_journal: self.journal,
            mediator_heard: self.hears && !self.stands_by,
            session: self.number,
            ..RobotReport::default()
        }
    }
}

impl Session {
    fn tell_protocols(&self, factsheet: &Factsheet) -> Factsheet {
        let control = (!self.without_control).then_some(CONTROL);
        Factsheet {
            protocols: [AREAS].into_iter().chain(control).collect(),
            ..factsheet.clone()
        }
    }
}

/// Whether a process whose newest report has one number may have sent one with another number since.
#[must_use]
pub fn is_reached_from(newest: u64, sequence: u64) -> bool {
    let most = newest.saturating_add(SEQUENCE_STEP).max(LAST_NUMBER / 2);
    sequence <= most.min(LAST_NUMBER)
}
