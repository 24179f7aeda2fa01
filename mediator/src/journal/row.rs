//! Keys and values of the journal's table.
//!
//! Keys are `format`, `site`, `file`, `epoch`, `robot/ROBOT`, `access/ROBOT/AREA`, `fence/AREA`, `adopted/AREA`, `closed/AREA`,
//! `revocation/ROBOT/AREA`, `number`, `coordination/NUMBER`, `order/NUMBER`; values are JSON.

use std::path::Path;

use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};

use super::entry::{Entry, Stored};
use super::error::StoreError;
use super::place::Place;

/// Of keys and values; a journal of another format is refused.
const FORMAT: u32 = 2;

/// The rows with which a journal begins.
pub(super) fn head(site: &str) -> [(&'static str, String); 2] {
    [("format", FORMAT.to_string()), ("site", json(&site))]
}

/// The key of the file that the journal is in.
pub(super) const FILE: &str = "file";

/// The file that a journal is in. A copy of it is another one.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct FileRecord {
    /// Drawn when it began.
    pub(super) journal: u64,
    pub(super) device: u64,
    pub(super) inode: u64,
    /// As [`Place::born_ns`]; earlier versions have not written it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(super) born_ns: Option<u64>,
}

impl FileRecord {
    pub(super) fn new(journal: u64, place: Place) -> Self {
        Self {
            journal,
            device: place.device,
            inode: place.inode,
            born_ns: place.born_ns,
        }
    }

    pub(super) fn place(self) -> Place {
        Place {
            device: self.device,
            inode: self.inode,
            born_ns: self.born_ns,
        }
    }

    pub(super) fn value(self) -> String {
        json(&self)
    }
}

/// Reads one row into what the journal holds.
pub(super) fn read(
    path: &Path,
    site: &str,
    key: &str,
    value: &str,
    stored: &mut Stored,
    file: &mut Option<FileRecord>,
) -> Result<(), StoreError> {
    let row = Row { path, key, value };
    let parts: Vec<&str> = key.split('/').collect();
    match parts[..] {
        ["format"] => row.expect("format", &FORMAT.to_string())?,
        ["site"] => row.expect("site", &json(&site))?,
        [FILE] => *file = Some(row.parse("a file")?),
        ["epoch"] => stored.epoch = row.parse("a number")?,
        ["robot", robot] => {
            stored
                .robots
                .insert(robot.to_owned(), row.parse("a robot")?);
        }
        ["access", robot, area] => {
            let place = (robot.to_owned(), area.to_owned());
            stored.access.insert(place, row.parse("a level")?);
        }
        ["fence", area] => {
            stored
                .fences
                .insert(area.to_owned(), row.parse("a number")?);
        }
        ["adopted", area] => {
            stored
                .adopted
                .insert(area.to_owned(), row.parse("a number")?);
        }
        ["closed", area] => {
            stored
                .closed
                .insert(area.to_owned(), row.parse("who has closed it")?);
        }
        ["revocation", robot, area] => {
            let place = (robot.to_owned(), area.to_owned());
            stored.revocations.insert(place, row.parse("a level")?);
        }
        ["number"] => stored.number = row.parse("a number")?,
        ["order", number] => {
            let number =
                { number.parse() }.map_err(|_| row.error("a number behind `order/`", number))?;
            stored.orders.insert(number, row.parse("an order")?);
        }
        ["coordination", number] => {
            let number = number
                .parse()
                .map_err(|_| row.error("a number behind `coordination/`", number))?;
            stored
                .coordinations
                .insert(number, row.parse("a coordination")?);
        }
        _ => return Err(row.error("no such key", value)),
    }
    Ok(())
}

/// One row, and the file that it is in.
struct Row<'a> {
    path: &'a Path,
    key: &'a str,
    value: &'a str,
}

impl Row<'_> {
    fn expect(&self, what: &'static str, expected: &str) -> Result<(), StoreError> {
        if self.value == expected {
            return Ok(());
        }
        Err(StoreError::Other {
            path: self.path.to_owned(),
            what,
            found: self.value.to_owned(),
            expected: expected.to_owned(),
        })
    }

    fn parse<T: DeserializeOwned>(&self, expected: &'static str) -> Result<T, StoreError> {
        serde_json::from_str(self.value).map_err(|_| self.error(expected, self.value))
    }

    fn error(&self, expected: &'static str, found: &str) -> StoreError {
        StoreError::Value {
            path: self.path.to_owned(),
            key: self.key.to_owned(),
            expected,
            found: found.to_owned(),
        }
    }
}

/// The key of what an entry changes.
pub(super) fn key(entry: &Entry) -> String {
    match entry {
        Entry::Epoch(_) => "epoch".to_owned(),
        Entry::Robot { robot, .. } => format!("robot/{robot}"),
        Entry::Access { robot, area, .. } => format!("access/{robot}/{area}"),
        Entry::Fence { area, .. } => format!("fence/{area}"),
        Entry::Adopted { area, .. } => format!("adopted/{area}"),
        Entry::Closed { area, .. } => format!("closed/{area}"),
        Entry::Revocation { robot, area, .. } => format!("revocation/{robot}/{area}"),
        Entry::Order { number, .. } => format!("order/{number}"),
        Entry::Number(_) => "number".to_owned(),
        Entry::Coordination { number, .. } => format!("coordination/{number}"),
    }
}

/// Its value; `None` takes the key away.
pub(super) fn value(entry: &Entry) -> Option<String> {
    Some(match entry {
        Entry::Epoch(epoch) => epoch.to_string(),
        Entry::Robot { record, .. } => json(record),
        Entry::Access { record, .. } => json(record),
        Entry::Fence { fence, .. } => fence.to_string(),
        Entry::Adopted { known, .. } => known.as_ref()?.to_string(),
        Entry::Closed { record, .. } => json(record.as_ref()?),
        Entry::Revocation { record, .. } => json(record),
        Entry::Order { record, .. } => json(record.as_ref()?),
        Entry::Number(number) => number.to_string(),
        Entry::Coordination { record, .. } => json(record.as_ref()?),
    })
}

fn json(value: &impl Serialize) -> String {
    serde_json::to_string(value).expect("numbers, strings and lists are always JSON")
}
