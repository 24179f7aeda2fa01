//! A journal that a power loss robs of its last writes.

use std::collections::VecDeque;

use crate::random::Random;
use mediator::journal::{Entry, Stored};

/// A power loss takes at most this many writes.
const LAST: usize = 3;

pub struct Journal {
    safe: Stored,
    last: VecDeque<Vec<Entry>>,
}

impl Default for Journal {
    fn default() -> Self {
        let safe = Stored {
            journal: 1,
            ..Stored::default()
        };
        let last = VecDeque::new();
        Self { safe, last }
    }
}

impl Journal {
    pub fn write(&mut self, entries: Vec<Entry>) {
        if entries.is_empty() {
            return;
        }
        let registers = |entry: &Entry| match entry {
            Entry::Robot { robot, record } => {
                let known = self.safe.robots.get(robot);
                record.session > 0 && known.is_none_or(|known| known.session == 0)
            }
            _ => false,
        };
        // A robot of which the journal knows nothing is not waited for: the first time that it registers is not lost.
        let barrier = entries.iter().any(registers);
        self.last.push_back(entries);
        if barrier {
            self.keep();
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

    /// Loses everything, as no disk does; the epoch is kept if `keep_epoch` says so.
    pub fn forget(&mut self, keep_epoch: bool) {
        self.keep();
        let epoch = if keep_epoch { self.safe.epoch } else { 0 };
        self.safe = Stored {
            epoch,
            journal: self.safe.journal + u64::from(!keep_epoch),
            ..Stored::default()
        };
    }

    /// What the next start reads.
    pub fn read(&mut self) -> &Stored {
        self.keep();
        &self.safe
    }
}
