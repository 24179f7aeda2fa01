//! Coordinations as the journal knows them: by names, so that a changed site or net is noticed.

use std::collections::BTreeMap;

use contract::level::PROTOCOL_ID;
use coordination::protocol::Level;
use serde::{Deserialize, Serialize};

/// A coordination that runs.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CoordinationRecord {
    /// Its id in the site file.
    pub coordination: String,
    /// The situation in which its net began; `None`: its robots are told to yield.
    pub situation: Option<String>,
    /// The marked places of the net.
    pub marking: Vec<String>,
    /// By source: how many events wait for it, as far as some do.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub waiting: BTreeMap<String, u32>,
    /// By role of the net, in its order.
    pub parts: Vec<PartRecord>,
}

/// A robot's part in a coordination.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PartRecord {
    /// The role.
    pub role: String,
    /// The robot.
    pub robot: String,
    /// How far the net has read and set its flags.
    pub level: LevelRecord,
    /// The robot's side, where it follows from protocol 1.
    pub own: Option<LevelRecord>,
    /// Areas that are kept for it, and whether they were granted since.
    pub kept: Vec<(String, bool)>,
}

/// A level as it is stored.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LevelRecord {
    run: u32,
    path: u16,
    progress: u16,
    after_abort: bool,
}

impl LevelRecord {
    /// The level.
    #[must_use]
    pub fn level(self) -> Level {
        Level {
            protocol: PROTOCOL_ID,
            run: self.run,
            path: self.path,
            progress: self.progress,
            after_abort: self.after_abort,
        }
    }
}

impl From<Level> for LevelRecord {
    fn from(level: Level) -> Self {
        Self {
            run: level.run,
            path: level.path,
            progress: level.progress,
            after_abort: level.after_abort,
        }
    }
}

/// A level as it is stored, for `#[serde(with)]`.
pub(super) mod level_record {
    use coordination::protocol::Level;
    use serde::{Deserialize, Deserializer, Serialize, Serializer};

    use super::LevelRecord;

    pub(crate) fn serialize<S: Serializer>(level: &Level, to: S) -> Result<S::Ok, S::Error> {
        LevelRecord::from(*level).serialize(to)
    }

    pub(crate) fn deserialize<'de, D: Deserializer<'de>>(from: D) -> Result<Level, D::Error> {
        LevelRecord::deserialize(from).map(LevelRecord::level)
    }
}
