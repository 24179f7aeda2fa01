//! The one owner of a robot's table: its lock, its run, and what is removed with it.

use std::fs::{self, File};
use std::io::{Seek, Write};
use std::path::PathBuf;
use std::process;

use super::lock::{Content, instance_path, lock_exclusively, read_content};
use super::namespace::{file_error, private_folder};
use super::sweep::{self, Removed};
use super::table_run::TableRun;
use super::{Namespace, SymbolError};

/// The lock of the one owner; dropping it removes whatever the run has left.
#[derive(Debug)]
pub(super) struct Owner {
    pub(super) run: TableRun,
    path: PathBuf,
    /// Unlocked by being closed, after the drop has removed the file.
    file: File,
}

impl Owner {
    /// Becomes the owner, and removes what dead owners left behind.
    pub(super) fn acquire(robot: &str, place: &Namespace) -> Result<(Self, Removed), SymbolError> {
        place.check(robot)?;
        let root = place.create_root()?;
        let path = instance_path(&root, robot);
        let file = lock_exclusively(robot, &path)?;
        let run = TableRun::new(&root, robot);
        let owner = Self { run, path, file };
        let dead = read_content(&owner.file).unwrap_or_default();
        let removed = sweep::remove_runs(&root, robot, dead)?;
        let folder = owner.run.folder();
        owner.write(false)?;
        private_folder()
            .create(&folder)
            .map_err(file_error("create the folder", &folder))?;
        Ok((owner, removed))
    }

    /// Tells others that the table can be opened.
    pub(super) fn publish(&self) -> Result<(), SymbolError> {
        self.write(true)
    }

    fn write(&self, ready: bool) -> Result<(), SymbolError> {
        let text = Content {
            pid: Some(process::id()),
            word: Some(self.run.word.clone()),
            bits: Some(usize::BITS),
            ready,
        }
        .to_text();
        // Cut after writing, so that the file is never empty in between.
        let mut file = &self.file;
        file.rewind()
            .and_then(|()| file.write_all(text.as_bytes()))
            .and_then(|()| file.set_len(text.len() as u64))
            .map_err(file_error("write", &self.path))
    }
}

impl Drop for Owner {
    fn drop(&mut self) {
        // Errors have nobody to go to here; the next start finds what is left by its name.
        let _ = sweep::remove_runs(&self.run.root, &self.run.robot, Content::default());
        let _ = sweep::remove_run(&self.run);
        let _ = fs::remove_file(&self.path);
    }
}
