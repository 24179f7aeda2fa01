//! The journal in an embedded store (redb): one file, one transaction for each write, on the disk when it returns.

use std::fs::{File, Permissions};
use std::io::ErrorKind;
use std::os::unix::fs::{MetadataExt, PermissionsExt};
use std::path::{Path, PathBuf};

use contract::draw::draw;
use contract::private;
use redb::{Database, ReadableDatabase, ReadableTable, StorageBackend, TableDefinition};

use super::entry::{Entry, Stored};
use super::error::StoreError;
use super::place::Place;
use super::row::{self, FileRecord};

/// Keys and values as in `row`.
const TABLE: TableDefinition<&str, &str> = TableDefinition::new("journal");

/// Opens the database: the first time, or after the disk has failed.
type Open = Box<dyn Fn() -> Result<(Database, Place), redb::Error> + Send>;

/// Opens the journal of this name, or an empty one.
fn file(path: &Path) -> Open {
    let path = path.to_owned();
    Box::new(move || {
        let file = private::open_or_make(&path).map_err(std::io::Error::from)?;
        let metadata = file.metadata()?;
        let same = file.try_clone()?;
        let database = Database::builder().create_file(file)?;
        // Earlier versions made it readable. Only now it is certain that it is a journal, and no other file of this user.
        if metadata.mode() & 0o077 != 0 {
            same.set_permissions(Permissions::from_mode(0o600))?;
        }
        Ok((database, Place::of(&metadata)))
    })
}

/// At the start, where whatever else the disk does not do may have another cause than the disk.
fn not_opened(path: &Path, error: redb::Error) -> StoreError {
    let is_full = matches!(
        &error,
        redb::Error::Io(error) if matches!(error.kind(), ErrorKind::StorageFull | ErrorKind::QuotaExceeded)
    );
    let (path, error) = (path.to_owned(), Box::new(error));
    if is_full {
        StoreError::Disk { path, error }
    } else {
        StoreError::Store { path, error }
    }
}

/// The journal of one site. Only one mediator can have it open.
pub struct Store {
    path: PathBuf,
    open: Open,
    /// None after the disk has failed, until it is opened again.
    database: Option<Database>,
    place: Place,
}

impl std::fmt::Debug for Store {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Store")
            .field("path", &self.path)
            .finish_non_exhaustive()
    }
}

impl Store {
    /// Opens the journal of `site`, or begins one, and reads all that it holds. Its file is private, in a folder of any mode.
    ///
    /// # Errors
    /// [`StoreError`] when it cannot be opened, is damaged, or is of another site.
    pub fn open(path: &Path, site: &str) -> Result<(Self, Stored), StoreError> {
        let is_there = !path
            .symlink_metadata()
            .is_err_and(|error| error.kind() == ErrorKind::NotFound);
        if !is_there && let Some(made) = Self::make(path, site)? {
            return Ok(made);
        }
        Self::begin(path, file(path), site, draw)
    }

    /// Begins a journal, which takes its name when it is whole: what a full disk leaves of one would pass for a damaged one. Nothing
    /// where somebody else was faster, or the file system knows no second names.
    fn make(path: &Path, site: &str) -> Result<Option<(Self, Stored)>, StoreError> {
        let mut other = path.as_os_str().to_owned();
        other.push(format!(".{:016x}", draw()));
        let other = PathBuf::from(other);
        let made = Self::begin(path, file(&other), site, draw);
        let is_named = made.is_ok() && std::fs::hard_link(&other, path).is_ok();
        // Where even that fails, nobody is misled by it.
        let _ = std::fs::remove_file(&other);
        let (mut store, stored) = made?;
        if !is_named {
            return Ok(None);
        }
        let folder = path.parent().filter(|folder| *folder != Path::new(""));
        let folder = folder.unwrap_or(Path::new("."));
        if let Err(error) = File::open(folder).and_then(|folder| folder.sync_all()) {
            tracing::warn!(
                "whether the new journal {} outlives a loss of power just now is not certain: {error}",
                path.display()
            );
        }
        store.open = file(path);
        Ok(Some((store, stored)))
    }

    /// The same in memory, or on what a test makes of a disk; a new journal has this number.
    ///
    /// # Errors
    /// As [`Store::open`].
    pub fn on(
        backend: impl StorageBackend + Clone,
        site: &str,
        journal: u64,
    ) -> Result<(Self, Stored), StoreError> {
        let open = move || {
            let database = Database::builder().create_with_backend(backend.clone())?;
            Ok((database, Place::default()))
        };
        Self::begin(Path::new("in memory"), Box::new(open), site, || journal)
    }

    fn begin(
        path: &Path,
        open: Open,
        site: &str,
        draw: impl FnOnce() -> u64,
    ) -> Result<(Self, Stored), StoreError> {
        let failed = |error: redb::Error| not_opened(path, error);
        let (database, place) = open().map_err(failed)?;
        let store = Self {
            path: path.to_owned(),
            open,
            database: Some(database),
            place,
        };
        store
            .write_strings(row::head(site).map(|(key, value)| (key, Some(value))), true)
            .map_err(failed)?;
        let (mut stored, file) = store.read(site)?;
        // A file that is locked for one process: only that one has this number. A copy's file is another one.
        let same = file.filter(|file| file.place().is(place));
        stored.journal = same.map_or_else(draw, |file| file.journal);
        let now = FileRecord::new(stored.journal, place);
        if same != Some(now) {
            store
                .write_strings([(row::FILE, Some(now.value()))], false)
                .map_err(failed)?;
        }
        Ok((store, stored))
    }

    /// Opens the same file again, as must be after the disk has failed.
    ///
    /// # Errors
    /// [`StoreError::Disk`] while the disk fails; [`StoreError::Replaced`] when it is another file by now.
    pub fn reopen(&mut self) -> Result<(), StoreError> {
        // Its lock goes first.
        self.database = None;
        let (database, place) = (self.open)().map_err(|error| self.failed(error))?;
        if !place.is(self.place) {
            return Err(StoreError::Replaced {
                path: self.path.clone(),
            });
        }
        self.database = Some(database);
        Ok(())
    }

    fn failed(&self, error: redb::Error) -> StoreError {
        let (path, error) = (self.path.clone(), Box::new(error));
        match *error {
            redb::Error::Io(_) | redb::Error::PreviousIo => StoreError::Disk { path, error },
            _ => StoreError::Store { path, error },
        }
    }

    fn database(&self) -> Result<&Database, redb::Error> {
        self.database.as_ref().ok_or(redb::Error::PreviousIo)
    }

    /// Writes entries, all or none. When it returns they are on the disk.
    ///
    /// # Errors
    /// [`StoreError::Disk`] when the disk is full or gone: [`reopen`](Self::reopen) it, and write the same again.
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
        .map_err(|error| self.failed(error))
    }

    fn write_strings<K: AsRef<str>>(
        &self,
        pairs: impl IntoIterator<Item = (K, Option<String>)>,
        keep_old: bool,
    ) -> Result<(), redb::Error> {
        let transaction = self.database()?.begin_write()?;
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
        let failed = |error: redb::Error| not_opened(&self.path, error);
        let transaction = { self.database().map_err(failed)? }
            .begin_read()
            .map_err(|error| failed(error.into()))?;
        let table = transaction
            .open_table(TABLE)
            .map_err(|error| failed(error.into()))?;
        let (mut stored, mut file) = (Stored::new(0), None);
        for row in table.iter().map_err(|error| failed(error.into()))? {
            let (key, value) = row.map_err(|error| failed(error.into()))?;
            let (key, value) = (key.value(), value.value());
            row::read(&self.path, site, key, value, &mut stored, &mut file)?;
        }
        Ok((stored, file))
    }
}
