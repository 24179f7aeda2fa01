//! The robot's side of protocol 1, without network, clock or floor: what to ask for, and what is granted.
//!
//! A robot tells a [`Client`] where it stands and where it wants to go ([`Client::step`]), hands it what the mediator says
//! ([`Client::receive`]), sends what [`Client::report`] gives, and keeps out of every area that [`Client::holds`] does not
//! name. Allocates; not for real-time threads.

use std::collections::BTreeMap;
use std::sync::Arc;

use coordination::protocol::{Change, FlagId, Party, Position, Protocol, Replica, Side};

use crate::level::{self, PROTOCOL_ID};
use crate::protocols::{self, ENTERED, GRANTED, RELEASED, REQUEST, RETURNED, ROBOT};
use crate::wire::{Access, AccessGrant, MediatorReport, Pose, RobotReport, TakeUp};
use crate::{VERSION, Version};

/// What the robot knows of itself.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Situation {
    /// The pose is certain enough to say in which areas the robot stands.
    pub located: bool,
    /// Areas that the footprint, with a margin for the pose's uncertainty, reaches into.
    pub stands_in: Vec<String>,
    /// Areas that the robot wants to have now, those it stands in included, in the order of asking.
    pub wanted: Vec<String>,
    /// Where it is.
    pub pose: Option<Pose>,
    /// State of its machine.
    pub fsm_state: String,
}

/// What became of a message of the mediator.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Received {
    /// Taken in.
    News,
    /// The robot was registered by it: levels were taken over.
    Registered,
    /// From the past, or for another boot of this robot.
    Stale,
    /// The mediator does not want this robot; [`Client::refusal`] says why.
    Refused,
    /// The mediator speaks another version.
    Version,
}

/// Counts since the start.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ClientCounters {
    /// Messages from the past.
    pub stale: u64,
    /// Levels that could not follow on ours.
    pub bad_levels: u64,
    /// Grants received.
    pub grants: u64,
    /// Grants that the mediator took away.
    pub aborted: u64,
}

#[derive(Clone, Debug)]
struct Flags {
    protocol: Arc<Protocol>,
    robot: Party,
    request: FlagId,
    granted: FlagId,
    entered: FlagId,
    released: FlagId,
    returned: FlagId,
    granted_at: Position,
    entered_at: Position,
}

#[derive(Clone, Debug)]
struct Run {
    replica: Replica,
    fence: u64,
    waits_for: String,
}

/// One robot's side of protocol 1.
#[derive(Clone, Debug)]
pub struct Client {
    robot_id: String,
    site: String,
    boot_epoch: u64,
    flags: Flags,
    sequence: u64,
    mediator_epoch: u64,
    mediator_sequence: u64,
    session: u64,
    heard_ns: u64,
    refusal: String,
    role: String,
    take_up: Option<TakeUp>,
    runs: BTreeMap<String, Run>,
    situation: Situation,
    counters: ClientCounters,
}

impl Client {
    /// A robot that has just started. `boot_epoch` is drawn at random at each start.
    #[must_use]
    pub fn new(robot_id: &str, site: &str, boot_epoch: u64) -> Self {
        Self {
            robot_id: robot_id.to_owned(),
            site: site.to_owned(),
            boot_epoch,
            flags: Flags::new(),
            sequence: 0,
            mediator_epoch: 0,
            mediator_sequence: 0,
            session: 0,
            heard_ns: 0,
            refusal: String::new(),
            role: String::new(),
            take_up: None,
            runs: BTreeMap::new(),
            situation: Situation::default(),
            counters: ClientCounters::default(),
        }
    }

    /// Takes in a message of the mediator, however late, repeated or out of order it is.
    pub fn receive(&mut self, message: &MediatorReport, now_ns: u64) -> Received {
        if message.robot_id != self.robot_id
            || message.boot_epoch != self.boot_epoch
            || message.mediator_epoch < self.mediator_epoch
            || (message.mediator_epoch == self.mediator_epoch
                && message.sequence <= self.mediator_sequence)
        {
            self.counters.stale += 1;
            return Received::Stale;
        }
        if VERSION.accept(Version::from(message.version)).is_err() {
            return Received::Version;
        }
        self.mediator_epoch = message.mediator_epoch;
        self.mediator_sequence = message.sequence;
        self.refusal.clone_from(&message.refusal);
        if message.session == 0 {
            self.session = 0;
            return Received::Refused;
        }
        self.heard_ns = now_ns;
        self.role.clone_from(&message.role);
        let registers = self.session != message.session;
        if registers {
            // What the mediator knows of this robot holds; there is nothing else yet.
            self.runs.clear();
            self.take_up.clone_from(&message.take_up);
            self.session = message.session;
        }
        for grant in &message.access {
            self.learn(grant, registers);
        }
        if registers {
            Received::Registered
        } else {
            Received::News
        }
    }

    fn learn(&mut self, grant: &AccessGrant, registers: bool) {
        let Ok(level) = level::decode(grant.level.as_ref()) else {
            self.counters.bad_levels += 1;
            return;
        };
        let flags = &self.flags;
        if registers {
            match Replica::resume(&flags.protocol, flags.robot, level) {
                Ok(replica) => {
                    self.runs.insert(
                        grant.area.clone(),
                        Run {
                            replica,
                            fence: grant.fence,
                            waits_for: grant.waits_for.clone(),
                        },
                    );
                }
                Err(_) => self.counters.bad_levels += 1,
            }
            return;
        }
        let run = self
            .runs
            .entry(grant.area.clone())
            .or_insert_with(|| flags.begin());
        if run.replica.merge(level).is_err() {
            self.counters.bad_levels += 1;
            return;
        }
        run.waits_for.clone_from(&grant.waits_for);
        while let Some(change) = run.replica.poll() {
            match change {
                Change::Flag(flag) if flag == flags.granted => self.counters.grants += 1,
                Change::Flag(_) => {}
                Change::Aborted => self.counters.aborted += 1,
            }
        }
        run.fence = if flags.is_held(run) { grant.fence } else { 0 };
    }

    /// Sets the robot's flags by where it is and wants to be. Returns whether there is news to report.
    pub fn step(&mut self, situation: Situation, now_ns: u64, silent_after_ns: u64) -> bool {
        let mut news = self.situation.stands_in != situation.stands_in
            || self.situation.located != situation.located
            || self.situation.fsm_state != situation.fsm_state;
        self.situation = situation;
        if self.session == 0 || !self.situation.located {
            return news;
        }
        let Situation {
            stands_in, wanted, ..
        } = &self.situation;
        let flags = &self.flags;
        for (area, run) in &mut self.runs {
            let (stands, wants) = (stands_in.contains(area), wanted.contains(area));
            let at = run.replica.position();
            if at == flags.granted_at && stands {
                news |= run.replica.set(flags.entered).is_ok();
            } else if at == flags.granted_at && !wants {
                news |= run.replica.set(flags.returned).is_ok();
            } else if at == flags.entered_at && !stands && !wants {
                news |= run.replica.set(flags.released).is_ok();
            }
            if !flags.is_held(run) {
                run.fence = 0;
            }
        }
        if self.is_mediator_silent(now_ns, silent_after_ns) {
            return news;
        }
        for area in wanted {
            let run = self
                .runs
                .entry(area.clone())
                .or_insert_with(|| flags.begin());
            if run.replica.position() == Position::START {
                news |= run.replica.set(flags.request).is_ok();
            }
        }
        news
    }

    /// The next report to send: on news, and at 5 Hz.
    pub fn report(&mut self) -> RobotReport {
        self.sequence += 1;
        let known = |run: &Run| run.replica.run() > 0 || run.replica.position() != Position::START;
        let access = self.runs.iter().filter(|(_, run)| known(run));
        RobotReport {
            version: Some(VERSION.into()),
            robot_id: self.robot_id.clone(),
            boot_epoch: self.boot_epoch,
            sequence: self.sequence,
            site: self.site.clone(),
            mediator_epoch: self.mediator_epoch,
            session: self.session,
            stands_in: self.situation.stands_in.clone(),
            located: self.situation.located,
            pose: self.situation.pose,
            fsm_state: self.situation.fsm_state.clone(),
            access: access
                .map(|(area, run)| Access {
                    area: area.clone(),
                    level: Some(level::encode(run.replica.level())),
                    fence: run.fence,
                })
                .collect(),
            revocations: Vec::new(),
            control: None,
        }
    }

    /// Whether the robot may be in the area.
    #[must_use]
    pub fn holds(&self, area: &str) -> bool {
        self.runs
            .get(area)
            .is_some_and(|run| self.flags.is_held(run))
    }

    /// What the robot waits for, and why, as the mediator says it.
    pub fn waiting(&self) -> impl Iterator<Item = (&str, &str)> {
        let waits =
            |run: &Run| run.replica.position() != Position::START && !self.flags.is_held(run);
        self.runs
            .iter()
            .filter(move |(_, run)| waits(run))
            .map(|(area, run)| (area.as_str(), run.waits_for.as_str()))
    }

    /// The mediator knows this boot of the robot.
    #[must_use]
    pub fn is_registered(&self) -> bool {
        self.session != 0
    }

    /// Nothing was heard of the mediator for longer than that.
    #[must_use]
    pub fn is_mediator_silent(&self, now_ns: u64, silent_after_ns: u64) -> bool {
        self.session == 0 || now_ns > self.heard_ns.saturating_add(silent_after_ns)
    }

    /// Why the mediator does not want this robot; empty when it does.
    #[must_use]
    pub fn refusal(&self) -> &str {
        &self.refusal
    }

    /// The role that the mediator knows for this robot.
    #[must_use]
    pub fn role(&self) -> &str {
        &self.role
    }

    /// Where this robot was and in which state, if it has restarted. Given once.
    pub fn take_up(&mut self) -> Option<TakeUp> {
        self.take_up.take()
    }

    /// Counts since the start.
    #[must_use]
    pub fn counters(&self) -> ClientCounters {
        self.counters
    }
}

impl Flags {
    fn new() -> Self {
        let protocol = protocols::access();
        let flag = |name| {
            protocol
                .flag(name)
                .expect("the access protocol has its flags")
        };
        let after = |at, flag| {
            protocol
                .after(at, flag)
                .expect("the access protocol has its order")
        };
        let (request, granted, entered) = (flag(REQUEST), flag(GRANTED), flag(ENTERED));
        let granted_at = after(after(Position::START, request), granted);
        Self {
            robot: protocol
                .party(ROBOT)
                .expect("the access protocol has its parties"),
            request,
            granted,
            entered,
            released: flag(RELEASED),
            returned: flag(RETURNED),
            granted_at,
            entered_at: after(granted_at, entered),
            protocol: Arc::new(protocol),
        }
    }

    fn begin(&self) -> Run {
        Run {
            replica: Replica::new(&self.protocol, PROTOCOL_ID, self.robot, 0),
            fence: 0,
            waits_for: String::new(),
        }
    }

    fn is_held(&self, run: &Run) -> bool {
        let at = run.replica.position();
        at == self.granted_at || at == self.entered_at
    }
}
