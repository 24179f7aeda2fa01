//! The robot's session: its identity, its registration with a start of the mediator, and which messages are stale.

use crate::wire::{MediatorReport, RobotReport, TakeUp};
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
    /// The mediator speaks another version.
    Version,
}

/// The robot's identity and its registration with a mediator.
#[derive(Clone, Debug)]
pub(super) struct Session {
    robot_id: String,
    site: String,
    boot_epoch: u64,
    /// Of the last report.
    sequence: u64,
    /// Of the newest start of the mediator that was heard.
    pub(super) mediator_epoch: u64,
    /// Of its newest message.
    mediator_sequence: u64,
    /// The registration; 0 without one.
    pub(super) number: u64,
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
            boot_epoch,
            sequence: 0,
            mediator_epoch: 0,
            mediator_sequence: 0,
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
        let newest = (self.mediator_epoch, self.mediator_sequence);
        if message.robot_id != self.robot_id
            || message.boot_epoch != self.boot_epoch
            || (message.mediator_epoch, message.sequence) <= newest
        {
            return Received::Stale;
        }
        if VERSION.accept(Version::from(message.version)).is_err() {
            return Received::Version;
        }
        self.mediator_epoch = message.mediator_epoch;
        self.mediator_sequence = message.sequence;
        self.refusal.clone_from(&message.refusal);
        self.identity_taken = message.identity_taken;
        self.identity_doubled = message.identity_doubled;
        if message.session == 0 {
            self.number = 0;
            return Received::Refused;
        }
        self.heard_ns = now_ns;
        self.role.clone_from(&message.role);
        if self.number == message.session {
            return Received::News;
        }
        self.number = message.session;
        self.take_up.clone_from(&message.take_up);
        Received::Registered
    }

    pub(super) fn is_registered(&self) -> bool {
        self.number != 0
    }

    pub(super) fn is_mediator_silent(&self, now_ns: u64, silent_after_ns: u64) -> bool {
        !self.is_registered() || now_ns > self.heard_ns.saturating_add(silent_after_ns)
    }

    /// The head of the next report.
    pub(super) fn next_report(&mut self) -> RobotReport {
        self.sequence += 1;
        RobotReport {
            version: Some(VERSION.into()),
            robot_id: self.robot_id.clone(),
            boot_epoch: self.boot_epoch,
            sequence: self.sequence,
            site: self.site.clone(),
            mediator_epoch: self.mediator_epoch,
            mediator_sequence: self.mediator_sequence,
            session: self.number,
            ..RobotReport::default()
        }
    }
}
