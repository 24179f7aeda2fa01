//! The truth about a robot, from the world, and a bounded log of it.

use std::collections::VecDeque;

use super::geometry::{Pose, Twist};

/// The truth about one robot at one time.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Truth {
    /// Monotonic time.
    pub time_ns: u64,
    /// `base_link` in `map`.
    pub pose: Pose,
    /// Speed and rate of turn.
    pub twist: Twist,
    /// Angle of the drive unit, without the encoder's zero error.
    pub pivot_rad: f64,
    /// Distance of the footprint to the nearest wall, obstacle or robot; 0 in contact.
    pub clearance_m: f64,
    /// The smallest clearance at any step so far.
    pub min_clearance_m: f64,
    /// Length of the path of `base_link`, forward and backward.
    pub distance_m: f64,
    /// Collisions so far; contacts less than half a second apart are one.
    pub collisions: u64,
    /// Those of them in which something ran into the standing robot.
    pub run_into: u64,
    /// It is touching something.
    pub in_contact: bool,
}

/// One line of the log.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TruthRecord {
    /// Counts all records ever logged.
    pub sequence: u64,
    /// Index of the robot in the world's configuration.
    pub robot: usize,
    /// What was true.
    pub truth: Truth,
}

/// The last records; older ones are discarded and counted.
#[derive(Debug, Clone)]
pub struct TruthLog {
    records: VecDeque<TruthRecord>,
    capacity: usize,
    next_sequence: u64,
}

impl TruthLog {
    pub(super) fn new(capacity: usize) -> TruthLog {
        TruthLog {
            records: VecDeque::new(),
            capacity,
            next_sequence: 0,
        }
    }

    pub(super) fn push(&mut self, robot: usize, truth: Truth) {
        if self.records.len() >= self.capacity {
            self.records.pop_front();
        }
        if self.capacity > 0 {
            self.records.push_back(TruthRecord {
                sequence: self.next_sequence,
                robot,
                truth,
            });
        }
        self.next_sequence += 1;
    }

    /// The records kept, oldest first.
    pub fn records(&self) -> impl Iterator<Item = &TruthRecord> {
        self.records.iter()
    }

    /// The records kept whose sequence number is at least this, for a reader that comes back from time to time
    /// with [`next_sequence`](Self::next_sequence) of its last visit.
    pub fn since(&self, sequence: u64) -> impl Iterator<Item = &TruthRecord> {
        let skip = sequence.saturating_sub(self.dropped());
        self.records
            .iter()
            .skip(usize::try_from(skip).unwrap_or(usize::MAX))
    }

    /// The number the next record will have.
    #[must_use]
    pub fn next_sequence(&self) -> u64 {
        self.next_sequence
    }

    /// Records discarded for newer ones.
    #[must_use]
    pub fn dropped(&self) -> u64 {
        self.next_sequence - self.records.len() as u64
    }
}
