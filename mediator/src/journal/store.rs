//! The journal in an embedded store (redb): one file, one transaction for each write, on the disk when it returns.

use std::path::{Path, PathBuf};

use redb::{Database, ReadableDatabase, ReadableTable, TableDefinition};
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};

use super::{
    AccessRecord, CoordinationRecord, Entry, LevelRecord, RevocationRecord, RobotRecord, Stored,
};

/// Keys are `format`, `site`, `epoch`, `robot/ROBOT`, `access/ROBOT/AREA`, `fence/AREA`, `revocation/ROBOT/AREA`, `number`,
/// `coordination/NUMBER`; values are JSON.
const TABLE: TableDefinition<&str, &str> = TableDefinition::new("journal");
/// Of keys and values.
const FORMAT: u32 = 2;

/// Why the journal cannot be used. The mediator must not go on without it.
#[derive(Debug, thiserror::Error)]
pub enum StoreError {
    /// The store itself.
    #[error(
        "journal {path}: {error}; if another mediator uses it, stop that one; if the file is damaged, move it away and start again when every robot stands still",
        path = path.display()
    )]
    Store {
        /// The file.
        path: PathBuf,
        /// What the store says.
        error: Box<redb::Error>,
    },
    /// A value that is not what its key promises.
    #[error("journal {path}, key `{key}`: expected {expected}, found `{found}`", path = path.display())]
    Value {
        /// The file.
        path: PathBuf,
        /// Which key.
        key: String,
        /// What belongs there.
        expected: &'static str,
        /// What is there.
        found: String,
    },
    /// The journal of somewhere else.
    #[error("journal {path} is of {what} `{found}`, expected `{expected}`: name another file", path = path.display())]
    Other {
        /// The file.
        path: PathBuf,
        /// Site or format.
        what: &'static str,
        /// As found.
        found: String,
        /// Ours.
        expected: String,
    },
}

/// The journal of one site. Only one mediator can have it open.
#[derive(Debug)]
pub struct Store {
    path: PathBuf,
    database: Database,
}

impl Store {
    /// Opens the journal of `site`, or begins one, and reads all that it holds.
    ///
    /// # Errors
    /// [`StoreError`] when it cannot be opened, is damaged, or is of another site.
    pub fn open(path: &Path, site: &str) -> Result<(Self, Stored), StoreError> {
        let failed = |error: redb::Error| StoreError::Store {
            path: path.to_owned(),
            error: Box::new(error),
        };
        let database = Database::create(path).map_err(|error| failed(error.into()))?;
        let store = Self {
            path: path.to_owned(),
            database,
        };
        store
            .write_strings(
                [
                    ("format", Some(FORMAT.to_string())),
                    ("site", Some(quoted(site))),
                ],
                true,
            )
            .map_err(failed)?;
        let stored = store.read(site)?;
        Ok((store, stored))
    }

    /// Writes entries, all or none. When it returns they are on the disk.
    ///
    /// # Errors
    /// [`StoreError::Store`] when the disk is full or gone.
    pub fn write(&self, entries: &[Entry]) -> Result<(), StoreError> {
        if entries.is_empty() {
            return Ok(());
        }
        self.write_strings(
            entries.iter().map(|entry| (key(entry), value(entry))),
            false,
        )
        .map_err(|error| StoreError::Store {
            path: self.path.clone(),
            error: Box::new(error),
        })
    }

    fn write_strings<K: AsRef<str>>(
        &self,
        pairs: impl IntoIterator<Item = (K, Option<String>)>,
        keep_old: bool,
    ) -> Result<(), redb::Error> {
        let transaction = self.database.begin_write()?;
        {
            let mut table = transaction.open_table(TABLE)?;
            for (key, value) in pairs {
                match value {
                    Some(_) if keep_old && table.get(key.as_ref())?.is_some() => {}
                    Some(value) => {
                        table.insert(key.as_ref(), value.as_str())?;
                    }
                    None => {
                        table.remove(key.as_ref())?;
                    }
                }
            }
        }
        transaction.commit()?;
        Ok(())
    }

    fn read(&self, site: &str) -> Result<Stored, StoreError> {
        let failed = |error: redb::Error| StoreError::Store {
            path: self.path.clone(),
            error: Box::new(error),
        };
        let transaction = self
            .database
            .begin_read()
            .map_err(|error| failed(error.into()))?;
        let table = transaction
            .open_table(TABLE)
            .map_err(|error| failed(error.into()))?;
        let mut stored = Stored::default();
        for row in table.iter().map_err(|error| failed(error.into()))? {
            let (key, value) = row.map_err(|error| failed(error.into()))?;
            self.read_row(site, key.value(), value.value(), &mut stored)?;
        }
        Ok(stored)
    }

    fn read_row(
        &self,
        site: &str,
        key: &str,
        value: &str,
        stored: &mut Stored,
    ) -> Result<(), StoreError> {
        let parts: Vec<&str> = key.split('/').collect();
        match parts[..] {
            ["format"] => self.expect("format", value, &FORMAT.to_string())?,
            ["site"] => self.expect("site", value, &quoted(site))?,
            ["epoch"] => stored.epoch = self.parse(key, value, "a number")?,
            ["robot", robot] => {
                let record: RobotRecord = self.parse(key, value, "a robot")?;
                stored.robots.insert(robot.to_owned(), record);
            }
            ["access", robot, area] => {
                let record: AccessValue = self.parse(key, value, "a level")?;
                let place = (robot.to_owned(), area.to_owned());
                stored.access.insert(place, record.into());
            }
            ["fence", area] => {
                let fence = self.parse(key, value, "a number")?;
                stored.fences.insert(area.to_owned(), fence);
            }
            ["revocation", robot, area] => {
                let value: RevocationValue = self.parse(key, value, "a level")?;
                let record = RevocationRecord {
                    level: value.level.level(),
                    fence: value.fence,
                };
                let place = (robot.to_owned(), area.to_owned());
                stored.revocations.insert(place, record);
            }
            ["number"] => stored.number = self.parse(key, value, "a number")?,
            ["coordination", number] => {
                let number = self.parse(key, number, "a number behind `coordination/`")?;
                let record: CoordinationRecord = self.parse(key, value, "a coordination")?;
                stored.coordinations.insert(number, record);
            }
            _ => {
                return Err(StoreError::Value {
                    path: self.path.clone(),
                    key: key.to_owned(),
                    expected: "no such key",
                    found: value.to_owned(),
                });
            }
        }
        Ok(())
    }

    fn expect(&self, what: &'static str, found: &str, expected: &str) -> Result<(), StoreError> {
        if found == expected {
            return Ok(());
        }
        Err(StoreError::Other {
            path: self.path.clone(),
            what,
            found: found.to_owned(),
            expected: expected.to_owned(),
        })
    }

    fn parse<T: DeserializeOwned>(
        &self,
        key: &str,
        value: &str,
        expected: &'static str,
    ) -> Result<T, StoreError> {
        serde_json::from_str(value).map_err(|_| StoreError::Value {
            path: self.path.clone(),
            key: key.to_owned(),
            expected,
            found: value.to_owned(),
        })
    }
}

/// [`AccessRecord`] as it is stored.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct AccessValue {
    level: LevelRecord,
    fence: u64,
    ticket: u64,
}

impl From<AccessRecord> for AccessValue {
    fn from(record: AccessRecord) -> Self {
        Self {
            level: record.level.into(),
            fence: record.fence,
            ticket: record.ticket,
        }
    }
}

impl From<AccessValue> for AccessRecord {
    fn from(value: AccessValue) -> Self {
        Self {
            level: value.level.level(),
            fence: value.fence,
            ticket: value.ticket,
        }
    }
}

/// [`RevocationRecord`] as it is stored.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct RevocationValue {
    level: LevelRecord,
    fence: u64,
}

impl From<RevocationRecord> for RevocationValue {
    fn from(record: RevocationRecord) -> Self {
        Self {
            level: record.level.into(),
            fence: record.fence,
        }
    }
}

fn key(entry: &Entry) -> String {
    match entry {
        Entry::Epoch(_) => "epoch".to_owned(),
        Entry::Robot { robot, .. } => format!("robot/{robot}"),
        Entry::Access { robot, area, .. } => format!("access/{robot}/{area}"),
        Entry::Fence { area, .. } => format!("fence/{area}"),
        Entry::Revocation { robot, area, .. } => format!("revocation/{robot}/{area}"),
        Entry::Number(_) => "number".to_owned(),
        Entry::Coordination { number, .. } => format!("coordination/{number}"),
    }
}

/// `None` takes the key away.
fn value(entry: &Entry) -> Option<String> {
    Some(match entry {
        Entry::Epoch(epoch) => epoch.to_string(),
        Entry::Robot { record, .. } => json(record),
        Entry::Access { record, .. } => json(&AccessValue::from(*record)),
        Entry::Fence { fence, .. } => fence.to_string(),
        Entry::Revocation { record, .. } => json(&RevocationValue::from(*record)),
        Entry::Number(number) => number.to_string(),
        Entry::Coordination { record, .. } => json(record.as_ref()?),
    })
}

fn quoted(text: &str) -> String {
    json(&text)
}

fn json(value: &impl Serialize) -> String {
    serde_json::to_string(value).expect("numbers, strings and lists are always JSON")
}

#[cfg(test)]
mod tests {
    use super::super::PartRecord;
    use super::*;
    use contract::level::PROTOCOL_ID;
    use coordination::protocol::Level;

    fn entries() -> Vec<Entry> {
        let level = Level {
            protocol: PROTOCOL_ID,
            run: 3,
            path: 1,
            progress: 2,
            after_abort: true,
        };
        vec![
            Entry::Epoch(2),
            Entry::Robot {
                robot: "amr-1".into(),
                record: RobotRecord {
                    session: 4,
                    boot_epoch: u64::MAX,
                    issued: 5,
                    retired: vec![1, 2],
                    stands_in: vec!["1".into(), "2".into()],
                    fsm_state: "drive-1".into(),
                },
            },
            Entry::Access {
                robot: "amr-1".into(),
                area: "1".into(),
                record: AccessRecord {
                    level,
                    fence: 9,
                    ticket: 7,
                },
            },
            Entry::Fence {
                area: "1".into(),
                fence: 9,
            },
            Entry::Revocation {
                robot: "amr-1".into(),
                area: "1".into(),
                record: RevocationRecord { level, fence: 9 },
            },
            Entry::Number(12),
            coordination(11),
            coordination(12),
            Entry::Coordination {
                number: 11,
                record: None,
            },
        ]
    }

    fn coordination(number: u64) -> Entry {
        let level = Level {
            protocol: PROTOCOL_ID,
            run: 0,
            path: 1,
            progress: 2,
            after_abort: false,
        };
        let record = CoordinationRecord {
            coordination: "overtaking".into(),
            situation: Some("normal-ahead".into()),
            marking: vec!["normal-in-1".into()],
            parts: vec![PartRecord {
                role: "normal".into(),
                robot: "amr-1".into(),
                level: level.into(),
                own: Some(level.into()),
                kept: vec![("5".into(), true)],
            }],
        };
        Entry::Coordination {
            number,
            record: Some(record),
        }
    }

    #[test]
    fn what_was_written_is_there_after_opening_again() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("journal.redb");
        let (store, stored) = Store::open(&path, "corridor").expect("opens");
        assert_eq!(stored, Stored::default());
        store.write(&entries()).expect("writes");
        store.write(&[Entry::Epoch(3)]).expect("writes");
        drop(store);
        let (_, stored) = Store::open(&path, "corridor").expect("opens again");
        let mut expected = Stored::default();
        entries()
            .into_iter()
            .for_each(|entry| expected.apply(entry));
        expected.apply(Entry::Epoch(3));
        assert_eq!(stored, expected);
    }

    #[test]
    fn the_journal_of_another_site_is_refused() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("journal.redb");
        drop(Store::open(&path, "corridor").expect("opens"));
        let error = Store::open(&path, "docking").expect_err("refused");
        let text = error.to_string();
        assert!(
            text.contains("corridor") && text.contains("docking"),
            "{text}"
        );
    }

    #[test]
    fn two_mediators_cannot_have_one_journal() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("journal.redb");
        let _open = Store::open(&path, "corridor").expect("opens");
        let error = Store::open(&path, "corridor").expect_err("refused");
        assert!(error.to_string().contains("another mediator"), "{error}");
    }

    #[test]
    fn a_file_that_is_no_journal_is_refused() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("journal.redb");
        std::fs::write(&path, "not a journal").expect("writes");
        assert!(Store::open(&path, "corridor").is_err());
    }
}
