//! A journal that a power loss robs of its last writes.

use std::collections::{BTreeMap, VecDeque};

use crate::random::Random;
use mediator::journal::{Entry, RobotRecord, Stored};

/// A power loss takes at most this many writes.
const LAST: usize = 3;

pub struct Journal {
    safe: Stored,
    last: VecDeque<Vec<Entry>>,
    /// As it was some time ago.
    copy: Stored,
    writes: u64,
}

/// What a journal that is broken on purpose still holds.
#[derive(Clone, Copy, PartialEq, Eq)]
pub enum Left {
    Nothing,
    Epoch,
    /// And that no robot is on the floor.
    Absence,
}

/// A copy is made each time that this many writes were made.
const COPIED_AFTER: u64 = 50;

impl Journal {
    /// A file that is new.
    pub fn of(number: u64) -> Self {
        let safe = Stored::new(number);
        Self {
            copy: safe.clone(),
            last: VecDeque::new(),
            writes: 0,
            safe,
        }
    }

    pub fn write(&mut self, entries: Vec<Entry>) {
        if entries.is_empty() {
            return;
        }
        self.last.push_back(entries);
        self.writes += 1;
        if self.writes.is_multiple_of(COPIED_AFTER) {
            self.copy = self.safe.clone();
        }
        if self.last.len() > LAST {
            self.keep_first();
        }
    }

    /// All that was written so far is on the disk for good.
    pub fn keep(&mut self) {
        while !self.last.is_empty() {
            self.keep_first();
        }
    }

    fn keep_first(&mut self) {
        for entry in self.last.pop_front().into_iter().flatten() {
            self.safe.apply(entry);
        }
    }

    /// Returns how many writes are lost.
    pub fn lose_power(&mut self, random: &mut Random) -> u64 {
        let before = self.last.len();
        let lost = random.below(LAST as u64 + 1) as usize;
        self.last.truncate(before.saturating_sub(lost));
        (before - self.last.len()) as u64
    }

    /// This process never speaks for the robot again, by what was written last.
    pub fn is_retired(&self, robot_id: &str, boot_epoch: u64) -> bool {
        let record = self.robot(robot_id);
        record
            .is_some_and(|own| own.retired.contains(&boot_epoch) || own.found.contains(&boot_epoch))
    }

    /// Where the body of this second process is, by what was written last.
    pub fn knows_second(&self, robot_id: &str, boot_epoch: u64) -> bool {
        let seconds = self.robot(robot_id).map(|own| &own.seconds);
        seconds.is_some_and(|all| all.iter().any(|own| own.boot_epoch == boot_epoch))
    }

    /// One speaks for the robot, by what was written last.
    pub fn knows(&self, robot_id: &str) -> bool {
        self.robot(robot_id).is_some_and(|own| own.session > 0)
    }

    /// The area is closed, by what was written last.
    pub fn has_closed(&self, area_id: &str) -> bool {
        let mut newest = self.newest_first();
        let newest = newest.find_map(|entry| match entry {
            Entry::Closed { area, record } if area == area_id => Some(record.is_some()),
            _ => None,
        });
        newest.unwrap_or_else(|| self.safe.closed.contains_key(area_id))
    }

    fn robot(&self, robot_id: &str) -> Option<&RobotRecord> {
        let newest = self.newest_first().find_map(|entry| match entry {
            Entry::Robot { robot, record } if robot == robot_id => Some(record),
            _ => None,
        });
        newest.or_else(|| self.safe.robots.get(robot_id))
    }

    /// What a power loss may still take.
    fn newest_first(&self) -> impl Iterator<Item = &Entry> {
        self.last.iter().rev().flat_map(|own| own.iter().rev())
    }

    /// Loses everything but this, as no disk does.
    pub fn forget(&mut self, left: Left) {
        self.keep();
        let mut robots = std::mem::take(&mut self.safe.robots);
        robots.values_mut().for_each(|robot| {
            robot.stands_in.clear();
            robot.absent = true;
        });
        self.safe = Stored {
            epoch: if left == Left::Nothing {
                0
            } else {
                self.safe.epoch
            },
            robots: if left == Left::Absence {
                robots
            } else {
                BTreeMap::new()
            },
            ..Stored::new(self.safe.journal + u64::from(left == Left::Nothing))
        };
    }

    pub fn forget_what_is_closed(&mut self) {
        self.keep();
        self.safe.closed.clear();
    }

    /// Somebody deletes the file, or puts a copy in its place: into the same file, or as another one.
    pub fn lose(&mut self, random: &mut Random) {
        self.keep();
        let journal = self.safe.journal;
        self.safe = match random.below(3) {
            0 => Stored::new(journal + 1),
            another_file => Stored {
                journal: journal + another_file - 1,
                ..self.copy.clone()
            },
        };
        self.copy = self.safe.clone();
    }

    /// What the next start reads.
    pub fn read(&mut self) -> &Stored {
        self.keep();
        &self.safe
    }
}
