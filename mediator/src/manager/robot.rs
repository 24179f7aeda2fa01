//! What the manager knows of one robot.

use super::revoke::Revocations;
use super::run::{Run, Runs};
use crate::journal::RobotRecord;
use contract::wire::Pose;

/// So many earlier boots are remembered, so that their late reports are known for what they are.
const RETIRED: usize = 64;

/// A process that has asked to speak for the robot and has not yet repeated its session. It may be a late message of a
/// process that is long gone, so the present one keeps speaking until then.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Candidate {
    pub(super) boot_epoch: u64,
    pub(super) session: u64,
    pub(super) since_ns: u64,
    /// There is news for it.
    pub(super) news: bool,
}

impl Candidate {
    /// One that gets no session, only the reason why not.
    pub(super) fn refused(boot_epoch: u64, now_ns: u64) -> Self {
        Self {
            boot_epoch,
            session: 0,
            since_ns: now_ns,
            news: true,
        }
    }
}

#[derive(Clone, Debug)]
pub(super) struct Robot {
    pub(super) id: String,
    pub(super) role: String,
    pub(super) priority: u32,
    /// Of the process that speaks for it; 0 before the first.
    pub(super) session: u64,
    pub(super) boot_epoch: u64,
    /// The last session number that was given out.
    issued: u64,
    pub(super) candidate: Option<Candidate>,
    retired: Vec<u64>,
    /// It has repeated its session to this mediator, so that both mean the same levels.
    pub(super) registered: bool,
    /// Of the last report of this boot.
    pub(super) sequence: u64,
    pub(super) heard_ns: u64,
    pub(super) silent: bool,
    pub(super) located: bool,
    /// It has said in this session where it stands.
    pub(super) placed: bool,
    /// Areas it reaches into, by index, sorted.
    pub(super) stands_in: Vec<usize>,
    /// Areas in which it stood when it registered, without a grant.
    pub(super) found_in: Vec<usize>,
    /// Areas for which it was last called an intruder.
    pub(super) intrudes_in: Vec<usize>,
    pub(super) pose: Option<Pose>,
    pub(super) fsm_state: String,
    /// Protocol 1 by area.
    pub(super) runs: Runs,
    /// Grants that were asked back.
    pub(super) revocations: Revocations,
    /// A process that was refused, and why.
    pub(super) refused: Option<(u64, String)>,
    /// Of the last message to it.
    pub(super) sent: u64,
    pub(super) sent_ns: u64,
    /// There is news for it.
    pub(super) news: bool,
}

impl Robot {
    pub(super) fn new(id: &str, role: &str, priority: u32) -> Self {
        Self {
            id: id.to_owned(),
            role: role.to_owned(),
            priority,
            session: 0,
            boot_epoch: 0,
            issued: 0,
            candidate: None,
            retired: Vec::new(),
            registered: false,
            sequence: 0,
            heard_ns: 0,
            silent: false,
            located: false,
            placed: false,
            stands_in: Vec::new(),
            found_in: Vec::new(),
            intrudes_in: Vec::new(),
            pose: None,
            fsm_state: String::new(),
            runs: Runs::default(),
            revocations: Revocations::new(),
            refused: None,
            sent: 0,
            sent_ns: 0,
            news: false,
        }
    }

    pub(super) fn restore(&mut self, record: RobotRecord, stands_in: Vec<usize>) {
        self.session = record.session;
        self.boot_epoch = record.boot_epoch;
        self.issued = record.issued;
        self.retired = record.retired;
        self.stands_in = stands_in;
        self.fsm_state = record.fsm_state;
    }

    pub(super) fn record(&self, area_id: impl Fn(usize) -> String) -> RobotRecord {
        RobotRecord {
            session: self.session,
            boot_epoch: self.boot_epoch,
            issued: self.issued,
            retired: self.retired.clone(),
            stands_in: self.stands_in.iter().map(|&area| area_id(area)).collect(),
            fsm_state: self.fsm_state.clone(),
        }
    }

    pub(super) fn is_retired(&self, boot_epoch: u64) -> bool {
        self.retired.contains(&boot_epoch)
    }

    /// A process unknown so far asks to speak for this robot.
    pub(super) fn invite(&mut self, boot_epoch: u64, now_ns: u64) {
        self.issued += 1;
        self.candidate = Some(Candidate {
            boot_epoch,
            session: self.issued,
            since_ns: now_ns,
            news: true,
        });
    }

    /// The candidate has repeated its session: it is alive, and from now on it speaks for the robot.
    pub(super) fn promote(&mut self, candidate: Candidate) {
        if self.session > 0 {
            if self.retired.len() == RETIRED {
                self.retired.remove(0);
            }
            self.retired.push(self.boot_epoch);
        }
        self.candidate = None;
        self.boot_epoch = candidate.boot_epoch;
        self.session = candidate.session;
        self.sequence = 0;
        self.registered = false;
        self.placed = false;
        self.located = false;
        self.found_in.clear();
    }

    /// Why that process is refused; empty when it is not.
    pub(super) fn refusal(&self, boot_epoch: u64) -> &str {
        let refused = self
            .refused
            .as_ref()
            .filter(|(boot, _)| *boot == boot_epoch);
        refused.map_or("", |(_, why)| why)
    }

    /// Reports, or can be expected to: nothing is granted to others where it may be.
    pub(super) fn is_heard(&self) -> bool {
        self.registered && !self.silent
    }

    pub(super) fn run(&self, area: usize) -> Option<&Run> {
        self.runs.get(area)
    }

    /// It has the area by a grant.
    pub(super) fn holds(&self, area: usize) -> bool {
        self.run(area).is_some_and(Run::is_held)
    }

    /// It may be in the area, by a grant or because it stands there.
    pub(super) fn occupies(&self, area: usize) -> bool {
        self.holds(area) || self.stands_in.contains(&area)
    }

    /// It reaches into the area and was not granted it; one that was found there is no intruder until it has left. Before it
    /// has said where it stands, nothing is known of that.
    pub(super) fn intrudes(&self, area: usize) -> bool {
        self.placed
            && self.stands_in.contains(&area)
            && !self.holds(area)
            && !self.found_in.contains(&area)
    }
}
