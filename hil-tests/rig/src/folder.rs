//! A folder of one run's own, removed with it.

use std::fs;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};

use sim::rt::monotonic_ns;

use contract::private;
use onboard::cli::Failure;

/// A fresh folder for what must not be seen by other runs.
#[derive(Debug)]
pub struct Folder(PathBuf);

impl Folder {
    /// Makes one.
    ///
    /// # Errors
    /// [`Failure::Refused`] when it cannot be made.
    pub fn new() -> Result<Self, Failure> {
        Self::fresh(&std::env::temp_dir())
    }

    /// Makes one in memory, as a robot's own is in `/run`, unless `TMPDIR` names a place: on a disk the files of its shared memory, which
    /// are written through to it, keep whoever starts robots by the thousand waiting.
    ///
    /// # Errors
    /// [`Failure::Refused`] when it cannot be made.
    pub fn in_memory() -> Result<Self, Failure> {
        if std::env::var_os("TMPDIR").is_some() {
            return Self::new();
        }
        Self::fresh(Path::new("/dev/shm")).or_else(|_| Self::new())
    }

    fn fresh(place: &Path) -> Result<Self, Failure> {
        Self::at(place.join(format!(
            "rig-{}-{}-{}",
            std::process::id(),
            monotonic_ns() % 1_000_000,
            count()
        )))
    }

    /// Makes one in this one, which may go first.
    ///
    /// # Errors
    /// [`Failure::Refused`] when it cannot be made.
    pub fn below(&self) -> Result<Self, Failure> {
        Self::at(self.0.join(count().to_string()))
    }

    fn at(path: PathBuf) -> Result<Self, Failure> {
        private::folder(&path).map_err(Failure::refused)?;
        Ok(Self(path))
    }

    /// Where it is.
    #[must_use]
    pub fn path(&self) -> &Path {
        &self.0
    }
}

/// A number that this process has not used for a folder.
fn count() -> u64 {
    static MADE: AtomicU64 = AtomicU64::new(0);
    MADE.fetch_add(1, Ordering::Relaxed)
}

impl Drop for Folder {
    fn drop(&mut self) {
        // What cannot be removed is no reason to fail.
        let _ = fs::remove_dir_all(&self.0);
    }
}
