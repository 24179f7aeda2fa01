//! Who speaks for one robot.

use crate::journal::RobotRecord;

/// The last 64 earlier boots are remembered, so that their late reports are recognised as such.
const RETIRED: usize = 64;

/// A process that has asked to speak for the robot and has not yet repeated its session. It may be a late message of a
/// process that is long gone, so the present one keeps speaking until then.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Candidate {
    pub(crate) boot_epoch: u64,
    /// 0: it gets none, only the reason.
    pub(crate) session: u64,
    pub(crate) since_ns: u64,
}

/// The process that speaks for a robot, and the one that asks to.
#[derive(Clone, Debug, Default)]
pub(crate) struct Session {
    /// Of the process that speaks for it; 0 before the first.
    pub(crate) number: u64,
    pub(crate) boot_epoch: u64,
    /// The last session number that was given out.
    issued: u64,
    pub(crate) candidate: Option<Candidate>,
    retired: Vec<u64>,
    /// It has repeated its session to this mediator, so that both mean the same levels.
    pub(crate) registered: bool,
    /// Of the last report of this boot.
    pub(crate) sequence: u64,
    pub(crate) heard_ns: u64,
    pub(crate) silent: bool,
    /// A process that was refused, and why.
    pub(crate) refused: Option<(u64, String)>,
    /// Of the last message to it.
    pub(crate) sent: u64,
    pub(crate) sent_ns: u64,
}

impl Session {
    pub(crate) fn restore(&mut self, record: &RobotRecord) {
        self.number = record.session;
        self.boot_epoch = record.boot_epoch;
        self.issued = record.issued;
        self.retired.clone_from(&record.retired);
    }

    /// What the journal must know of it.
    pub(crate) fn record(&self) -> RobotRecord {
        RobotRecord {
            session: self.number,
            boot_epoch: self.boot_epoch,
            issued: self.issued,
            retired: self.retired.clone(),
            ..RobotRecord::default()
        }
    }

    pub(crate) fn is_retired(&self, boot_epoch: u64) -> bool {
        self.retired.contains(&boot_epoch)
    }

    /// A process speaks for the robot, and it is that one.
    pub(crate) fn is_of(&self, boot_epoch: u64) -> bool {
        self.number > 0 && self.boot_epoch == boot_epoch
    }

    /// A process unknown so far asks to speak for this robot, and is offered a session.
    pub(crate) fn invite(&mut self, boot_epoch: u64, now_ns: u64) {
        self.issued += 1;
        self.candidate = Some(Candidate {
            boot_epoch,
            session: self.issued,
            since_ns: now_ns,
        });
    }

    /// A process that does not speak for the robot is refused.
    pub(crate) fn refuse(&mut self, boot_epoch: u64, why: String, now_ns: u64) {
        self.refused = Some((boot_epoch, why));
        if !self.is_of(boot_epoch) {
            self.candidate = Some(Candidate {
                boot_epoch,
                session: 0,
                since_ns: now_ns,
            });
        }
    }

    /// The candidate has repeated its session: it is alive, and from now on it speaks for the robot.
    pub(crate) fn promote(&mut self, candidate: Candidate) {
        if self.number > 0 {
            if self.retired.len() == RETIRED {
                self.retired.remove(0);
            }
            self.retired.push(self.boot_epoch);
        }
        self.candidate = None;
        self.boot_epoch = candidate.boot_epoch;
        self.number = candidate.session;
        self.sequence = 0;
        self.registered = false;
    }

    /// Why that process is refused; empty when it is not.
    pub(crate) fn refusal(&self, boot_epoch: u64) -> &str {
        let refused = { self.refused.as_ref() }.filter(|(boot, _)| *boot == boot_epoch);
        refused.map_or("", |(_, why)| why)
    }

    /// It reports, so that it can use a grant.
    pub(crate) fn is_heard(&self) -> bool {
        self.registered && !self.silent
    }
}
