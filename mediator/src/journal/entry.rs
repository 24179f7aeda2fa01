//! Entries, and all that they add up to.

use std::collections::BTreeMap;
use std::fmt;

use coordination::protocol::Level;
use serde::{Deserialize, Serialize};

use super::record::{CoordinationRecord, level_record};

/// A change that must be stored before anybody is told of it.
#[derive(Clone, Debug, PartialEq)]
#[expect(missing_docs, reason = "the names say what each field is")]
pub enum Entry {
    /// The mediator has started, or has taken a larger number than that of another one.
    Epoch(u64),
    /// A robot has another session, or stands elsewhere.
    Robot { robot: String, record: RobotRecord },
    /// Protocol 1 of a robot and an area went on.
    Access {
        robot: String,
        area: String,
        record: AccessRecord,
    },
    /// An area was granted with this fence.
    Fence {
        area: String,
        /// Larger than every one before.
        fence: u64,
    },
    /// Robots have said that they were granted an area, of which this journal knows nothing.
    Adopted {
        area: String,
        /// The last fence up to which it knows of all grants; `None`: of all again.
        known: Option<u64>,
    },
    /// An operator has closed an area, or opened it again.
    Closed {
        area: String,
        /// By whom; `None`: it is open.
        record: Option<ClosedRecord>,
    },
    /// A grant is asked back, or that was answered.
    Revocation {
        robot: String,
        area: String,
        record: RevocationRecord,
    },
    /// An operator has ordered something.
    Order {
        /// Counts from 1.
        number: u64,
        /// What; `None`: it is too long ago to be kept.
        record: Option<OrderRecord>,
    },
    /// The last number that a coordination got.
    Number(u64),
    /// A coordination went on.
    Coordination {
        number: u64,
        /// Where it is; `None`: it is over.
        record: Option<CoordinationRecord>,
    },
}

/// A robot as the journal knows it.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RobotRecord {
    /// Of the process that speaks for it; 0 before the first.
    pub session: u64,
    /// Of that process.
    pub boot_epoch: u64,
    /// The last session number that was given out.
    pub issued: u64,
    /// Of the last boots before; none of them ever comes back.
    pub retired: Vec<u64>,
    /// Of the last processes that were found beside the one that spoke for it: none of them ever speaks for it.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub found: Vec<u64>,
    /// Where the bodies of such processes stand, for all that is known.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub seconds: Vec<SecondRecord>,
    /// Areas that it was last known to reach into.
    pub stands_in: Vec<String>,
    /// State of its machine then.
    pub fsm_state: String,
    /// Another mediator may have granted it what this journal does not know: what it says next is taken over.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub unaccounted: bool,
    /// An operator has said that it is nowhere, and it was not heard since: nobody waits for it.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub absent: bool,
}

/// A process beside the one that speaks for its robot, or that was refused alone, as the journal knows it.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SecondRecord {
    /// Its boot epoch.
    pub boot_epoch: u64,
    /// Number of a report that it has sent: older ones say nothing of where it is.
    #[serde(default)]
    pub sequence: u64,
    /// It was refused while none that speaks for the robot was heard: a new one that is taken in is its next process.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub alone: bool,
    /// Areas that its body was last known to reach into,
    pub stands_in: Vec<String>,
    /// and those where that is the robot's own body, for all that is known.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub with_robot: Vec<String>,
    /// It spoke for the robot before the process that does now, or is to, which has not said yet where it stands.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub before: Option<Before>,
}

/// Where a process stood that spoke for a robot before another one, when it was heard last.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Before {
    /// In at least one area.
    Inside,
    /// In none.
    Outside,
}

/// A run of protocol 1 as the journal knows it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct AccessRecord {
    /// How far.
    #[serde(with = "level_record")]
    pub level: Level,
    /// Of the grant; 0 before there is one.
    pub fence: u64,
    /// Its place in the order of requests; 0 when none is waiting.
    pub ticket: u64,
    /// Later requests that were granted before it, by which it ages.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub passed: u32,
}

fn is_zero(number: &u32) -> bool {
    *number == 0
}

impl AccessRecord {
    /// Of a robot's own word, which knows nothing of the order of requests.
    #[must_use]
    pub fn said(level: Level, fence: u64) -> Self {
        Self {
            level,
            fence,
            ticket: 0,
            passed: 0,
        }
    }
}

/// A revocation as the journal knows it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RevocationRecord {
    /// How far.
    #[serde(with = "level_record")]
    pub level: Level,
    /// Of the grant that is asked back.
    pub fence: u64,
}

/// What an operator has ordered, for people.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct OrderRecord {
    /// When, by the mediator's clock (RFC 3339).
    pub at: String,
    /// Who, such as `operator anna` or `user 1000`.
    pub who: String,
    /// As it is typed.
    pub order: String,
    /// Whether it was carried out.
    pub done: bool,
    /// What was answered.
    pub answer: String,
}

/// Who has closed an area, for people.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ClosedRecord {
    /// When, by the mediator's clock (RFC 3339).
    pub at: String,
    /// Who, such as `operator anna` or `user 1000`.
    pub who: String,
    /// Why; empty: nobody said.
    pub why: String,
}

impl fmt::Display for ClosedRecord {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} at {}", self.who, self.at)?;
        if self.why.is_empty() {
            return Ok(());
        }
        write!(f, ": {}", self.why)
    }
}

/// All that a journal holds.
#[derive(Clone, Debug, PartialEq)]
pub struct Stored {
    /// Drawn when its file began, never 0. No two processes have one with the same number open.
    pub journal: u64,
    /// Of the last start of the mediator; 0: this journal is new.
    pub epoch: u64,
    /// By id.
    pub robots: BTreeMap<String, RobotRecord>,
    /// By robot and area.
    pub access: BTreeMap<(String, String), AccessRecord>,
    /// Of the last grant, by area.
    pub fences: BTreeMap<String, u64>,
    /// The last fence up to which all grants are known, by area; of others it is that of the last grant.
    pub adopted: BTreeMap<String, u64>,
    /// Areas that an operator has closed.
    pub closed: BTreeMap<String, ClosedRecord>,
    /// By robot and area.
    pub revocations: BTreeMap<(String, String), RevocationRecord>,
    /// The last number that a coordination got.
    pub number: u64,
    /// Those that run, by number.
    pub coordinations: BTreeMap<u64, CoordinationRecord>,
    /// The last ones of the operators, by number.
    pub orders: BTreeMap<u64, OrderRecord>,
}

impl Stored {
    /// A journal that is new, with that number.
    #[must_use]
    pub fn new(journal: u64) -> Self {
        Self {
            journal,
            epoch: 0,
            robots: BTreeMap::new(),
            access: BTreeMap::new(),
            fences: BTreeMap::new(),
            adopted: BTreeMap::new(),
            closed: BTreeMap::new(),
            revocations: BTreeMap::new(),
            number: 0,
            coordinations: BTreeMap::new(),
            orders: BTreeMap::new(),
        }
    }

    /// Takes over an entry.
    pub fn apply(&mut self, entry: Entry) {
        match entry {
            Entry::Epoch(epoch) => self.epoch = epoch,
            Entry::Robot { robot, record } => {
                self.robots.insert(robot, record);
            }
            Entry::Access {
                robot,
                area,
                record,
            } => {
                self.access.insert((robot, area), record);
            }
            Entry::Fence { area, fence } => {
                self.fences.insert(area, fence);
            }
            Entry::Adopted { area, known } => match known {
                Some(known) => {
                    self.adopted.insert(area, known);
                }
                None => {
                    self.adopted.remove(&area);
                }
            },
            Entry::Closed { area, record } => match record {
                Some(record) => {
                    self.closed.insert(area, record);
                }
                None => {
                    self.closed.remove(&area);
                }
            },
            Entry::Revocation {
                robot,
                area,
                record,
            } => {
                self.revocations.insert((robot, area), record);
            }
            Entry::Order { number, record } => match record {
                Some(record) => {
                    self.orders.insert(number, record);
                }
                None => {
                    self.orders.remove(&number);
                }
            },
            Entry::Number(number) => self.number = number,
            Entry::Coordination { number, record } => match record {
                Some(record) => {
                    self.coordinations.insert(number, record);
                }
                None => {
                    self.coordinations.remove(&number);
                }
            },
        }
    }
}
