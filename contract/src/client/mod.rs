//! The robot's side of its protocols, without network, clock or floor: what to ask for, what is granted, what is ordered.
//!
//! A robot tells a [`Client`] where it stands and where it wants to go ([`Client::step`]), hands it what the mediator says
//! ([`Client::receive`]), sends what [`Client::report`] gives, and keeps out of every area that [`Client::holds`] does not
//! name.
//!
//! While it [is acquired](Client::is_acquired), its state machine does nothing by itself: it gets the events of
//! [orders](Client::next_order), and [what it outputs](Client::output) tells the mediator how far it is. The client then asks
//! for no areas but those that the robot stands in, cannot avoid any more, or was ordered to enter.
//!
//! Allocates; not for real-time threads.

mod access;
mod control;
mod revocation;

use std::collections::BTreeMap;

use coordination::protocol::{Change, Merged, Position, Replica, Side};

use crate::level;
use crate::wire::{self, Access, AccessGrant, MediatorReport, Pose, RobotReport, TakeUp};
use crate::{VERSION, Version};
use access::{AccessProtocol, Run};
use control::Control;
use revocation::{Revocation, RevocationProtocol};

pub use control::Order;

/// What the robot knows of itself.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Situation {
    /// The pose is certain enough to say in which areas the robot stands.
    pub located: bool,
    /// Areas that the footprint, with a margin for the pose's uncertainty, reaches into.
    pub stands_in: Vec<String>,
    /// Areas that the robot wants to have now, those it stands in included, in the order of asking.
    pub wanted: Vec<String>,
    /// Areas that it can no longer stop before.
    pub committed: Vec<String>,
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
    /// Grants given back because the mediator asked.
    pub yielded: u64,
    /// Grants kept although the mediator asked.
    pub kept: u64,
    /// Orders handed out.
    pub orders: u64,
    /// Coordinations that ended without a release: the mediator knows nothing of them.
    pub let_go: u64,
}

/// One robot's side of its protocols.
#[derive(Clone, Debug)]
pub struct Client {
    robot_id: String,
    site: String,
    boot_epoch: u64,
    flags: AccessProtocol,
    revoking: RevocationProtocol,
    sequence: u64,
    mediator_epoch: u64,
    mediator_sequence: u64,
    session: u64,
    heard_ns: u64,
    refusal: String,
    role: String,
    take_up: Option<TakeUp>,
    runs: BTreeMap<String, Run>,
    revocations: BTreeMap<String, Revocation>,
    control: Option<Control>,
    /// Of a coordination that is gone.
    last_order: Option<Order>,
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
            flags: AccessProtocol::new(),
            revoking: RevocationProtocol::new(),
            sequence: 0,
            mediator_epoch: 0,
            mediator_sequence: 0,
            session: 0,
            heard_ns: 0,
            refusal: String::new(),
            role: String::new(),
            take_up: None,
            runs: BTreeMap::new(),
            revocations: BTreeMap::new(),
            control: None,
            last_order: None,
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
            self.revocations.clear();
            self.control = None;
            self.last_order = None;
            self.take_up.clone_from(&message.take_up);
            self.session = message.session;
        }
        for grant in &message.access {
            self.learn(grant, registers);
        }
        for revocation in &message.revocations {
            self.learn_revocation(revocation, registers);
        }
        self.learn_control(message.control.as_ref(), registers);
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
                            inherited: true,
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
        let Ok(merged) = run.replica.merge(level) else {
            self.counters.bad_levels += 1;
            return;
        };
        run.waits_for.clone_from(&grant.waits_for);
        if merged == Merged::Nothing {
            // Its fence may be that of a mediator which has forgotten the grant.
            return;
        }
        while let Some(change) = run.replica.poll() {
            match change {
                Change::Flag(flag) if flag == flags.granted => self.counters.grants += 1,
                Change::Flag(_) => {}
                Change::Aborted => self.counters.aborted += 1,
            }
        }
        run.fence = if flags.is_held(run) { grant.fence } else { 0 };
    }

    fn learn_revocation(&mut self, message: &Access, registers: bool) {
        if registers {
            match self.revoking.resume(message) {
                Some(revocation) => {
                    self.revocations.insert(message.area.clone(), revocation);
                }
                None => self.counters.bad_levels += 1,
            }
            return;
        }
        let revocation = self.revocations.entry(message.area.clone());
        let revocation = revocation.or_insert_with(|| self.revoking.begin());
        if !revocation.learn(message) {
            self.counters.bad_levels += 1;
        }
    }

    fn learn_control(&mut self, message: Option<&wire::Control>, registers: bool) {
        let present = self.control.as_ref().map_or(0, |own| own.coordination);
        let learned = match (message, &mut self.control) {
            (None, None) => Ok(()),
            (None, Some(control)) => {
                if let Some(order) = control.let_go() {
                    self.counters.let_go += 1;
                    self.last_order = Some(order);
                }
                self.control = None;
                Ok(())
            }
            (Some(message), Some(control)) if message.coordination == present => {
                control.learn(message)
            }
            (Some(message), _) if message.coordination > present => {
                Control::join(message, registers).map(|control| self.control = Some(control))
            }
            // A smaller one is over.
            (Some(_), _) => Ok(()),
        };
        if learned.is_err() {
            self.counters.bad_levels += 1;
        }
    }

    /// Sets the robot's flags by where it is and wants to be. Returns whether there is news to report.
    pub fn step(&mut self, situation: Situation, now_ns: u64, silent_after_ns: u64) -> bool {
        let mut news = self.situation.stands_in != situation.stands_in
            || self.situation.located != situation.located
            || self.situation.fsm_state != situation.fsm_state;
        self.situation = situation;
        if self.session == 0 {
            return news;
        }
        if let Some(control) = &mut self.control {
            news |= control.advance();
        }
        if !self.situation.located {
            return news;
        }
        let wanted = self.wanted();
        let Situation {
            stands_in,
            committed,
            ..
        } = &self.situation;
        let flags = &self.flags;
        for (area, revocation) in &mut self.revocations {
            if !revocation.is_asked() {
                continue;
            }
            let grant = { self.runs.get_mut(area) }
                .filter(|run| flags.is_held(run) && run.fence == revocation.fence);
            let needs = stands_in.contains(area) || committed.contains(area);
            let yields = match grant {
                // It was given back before, on the same account.
                None => true,
                Some(run) if run.replica.position() == flags.granted_at && !needs => {
                    run.replica.set(flags.returned).is_ok()
                }
                Some(_) => false,
            };
            news |= self.revoking.answer(revocation, yields);
            let count = if yields {
                &mut self.counters.yielded
            } else {
                &mut self.counters.kept
            };
            *count += 1;
        }
        for (area, run) in &mut self.runs {
            let (stands, wants) = (stands_in.contains(area), wanted.contains(area));
            // What it was granted before it restarted and does not stand in, it gives back: the mediator may have lost more.
            let inherited = std::mem::take(&mut run.inherited);
            let wants = wants && !inherited;
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
        for area in &wanted {
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

    /// What to ask for and to keep. Others decide about a robot that is acquired.
    fn wanted(&mut self) -> Vec<String> {
        let situation = &self.situation;
        let stands = |area: &String| situation.stands_in.contains(area);
        let own = situation.wanted.iter().chain(&situation.committed);
        let mut wanted: Vec<String> = match &mut self.control {
            Some(control) if control.is_acquired() => {
                // An area that was entered and left is not asked for again.
                let left: Vec<String> = { control.areas().iter() }
                    .filter(|area| {
                        let run = self.runs.get(*area);
                        let entered =
                            run.is_some_and(|run| run.replica.position() == self.flags.entered_at);
                        entered && !stands(area)
                    })
                    .cloned()
                    .collect();
                left.iter().for_each(|area| control.left(area));
                let keeps = |area: &&String| stands(area) || situation.committed.contains(area);
                let ordered = control.areas().iter();
                own.filter(keeps).chain(ordered).cloned().collect()
            }
            _ => own.cloned().collect(),
        };
        let mut seen = std::collections::HashSet::new();
        wanted.retain(|area| seen.insert(area.clone()));
        wanted
    }

    /// The state machine has fired an output. Returns whether that sets a flag, which is to be reported.
    pub fn output(&mut self, output: &str) -> bool {
        self.control
            .as_mut()
            .is_some_and(|control| control.output(output))
    }

    /// The next order of the mediator, each handed out once. Take them before [`step`](Self::step): flags that say that an
    /// order was received are set only then.
    pub fn next_order(&mut self) -> Option<Order> {
        let order = self.last_order.take();
        let order = order.or_else(|| self.control.as_mut()?.next_order());
        self.counters.orders += u64::from(order.is_some());
        order
    }

    /// The mediator has the discrete control: the state machine does nothing by itself.
    #[must_use]
    pub fn is_acquired(&self) -> bool {
        self.control.as_ref().is_some_and(Control::is_acquired)
    }

    /// The coordination that the robot takes part in: its number, its net, and the flags set so far, for people.
    #[must_use]
    pub fn coordination(&self) -> Option<(u64, &str, String)> {
        let control = self.control.as_ref()?;
        Some((control.coordination, &control.net, control.describe()))
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
            revocations: { self.revocations.iter() }
                .filter(|(_, revocation)| revocation.is_known())
                .map(|(area, revocation)| revocation.report(area))
                .collect(),
            control: self.control.as_ref().map(Control::report),
        }
    }

    /// Whether the robot may be in the area.
    #[must_use]
    pub fn holds(&self, area: &str) -> bool {
        let run = self.runs.get(area);
        run.is_some_and(|run| self.flags.is_held(run) && !run.inherited)
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

#[cfg(test)]
mod tests;
