//! A folder of one run's own, removed with it.

use std::fs;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};

use sim::rt::monotonic_ns;

use onboard::cli::Failure;

use crate::output::make_folder;

/// A fresh folder for what must not be seen by other runs.
#[derive(Debug)]
pub struct Folder(PathBuf);

impl Folder {
    /// Makes one.
    ///
    /// # Errors
    /// [`Failure::Refused`] when it cannot be made.
    pub fn new() -> Result<Self, Failure> {
        static MADE: AtomicU64 = AtomicU64::new(0);
        let folder = std::env::temp_dir().join(format!(
            "rig-{}-{}-{}",
            std::process::id(),
            monotonic_ns() % 1_000_000,
            MADE.fetch_add(1, Ordering::Relaxed)
        ));
        make_folder(&folder)?;
        Ok(Self(folder))
    }

    /// Where it is.
    #[must_use]
    pub fn path(&self) -> &Path {
        &self.0
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        // What cannot be removed is no reason to fail.
        let _ = fs::remove_dir_all(&self.0);
    }
}
