//! The journal in an embedded store (redb): one file, one transaction for each write, on the disk when it returns.

use std::fs::File;
use std::os::unix::fs::MetadataExt;
use std::path::{Path, PathBuf};

use redb::{Database, ReadableDatabase, ReadableTable, StorageBackend, TableDefinition};

use super::entry::{Entry, Stored};
use super::error::StoreError;
use super::row::{self, FileRecord};
use crate::draw::draw;

/// Keys and values as in `row`.
const TABLE: TableDefinition<&str, &str> = TableDefinition::new("journal");

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
        let mut options = File::options();
        options.read(true).write(true).create(true).truncate(false);
        let file = { options.open(path) }.map_err(|error| failed(error.into()))?;
        let metadata = file.metadata().map_err(|error| failed(error.into()))?;
        let database =
            { Database::builder().create_file(file) }.map_err(|error| failed(error.into()))?;
        Self::begin(path, database, site, [metadata.dev(), metadata.ino()])
    }

    /// The same in memory, or on what a test makes of a disk.
    ///
    /// # Errors
    /// As [`Store::open`].
    pub fn on(backend: impl StorageBackend, site: &str) -> Result<(Self, Stored), StoreError> {
        let path = Path::new("in memory");
        let database = Database::builder().create_with_backend(backend);
        let database = database.map_err(|error| StoreError::Store {
            path: path.to_owned(),
            error: Box::new(error.into()),
        })?;
        Self::begin(path, database, site, [0; 2])
    }

    fn begin(
        path: &Path,
        database: Database,
        site: &str,
        [device, inode]: [u64; 2],
    ) -> Result<(Self, Stored), StoreError> {
        let failed = |error: redb::Error| StoreError::Store {
            path: path.to_owned(),
            error: Box::new(error),
        };
        let store = Self {
            path: path.to_owned(),
            database,
        };
        store
            .write_strings(row::head(site).map(|(key, value)| (key, Some(value))), true)
            .map_err(failed)?;
        let (mut stored, file) = store.read(site)?;
        // A file that is locked for one process: only that one has this number. A copy's file is another one.
        let same = file.filter(|file| (file.device, file.inode) == (device, inode));
        stored.journal = match same {
            Some(file) => file.journal,
            None => {
                let file = FileRecord {
                    journal: draw(),
                    device,
                    inode,
                };
                store
                    .write_strings([(row::FILE, Some(file.value()))], false)
                    .map_err(failed)?;
                file.journal
            }
        };
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
            entries
                .iter()
                .map(|entry| (row::key(entry), row::value(entry))),
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

    fn read(&self, site: &str) -> Result<(Stored, Option<FileRecord>), StoreError> {
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
        let (mut stored, mut file) = (Stored::default(), None);
        for row in table.iter().map_err(|error| failed(error.into()))? {
            let (key, value) = row.map_err(|error| failed(error.into()))?;
            let (key, value) = (key.value(), value.value());
            row::read(&self.path, site, key, value, &mut stored, &mut file)?;
        }
        Ok((stored, file))
    }
}
