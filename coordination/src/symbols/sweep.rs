//! Removing what a run has left: its folder, its shared memory, its instance file.
//!
//! Everything of a run has the run's word in its name, so removing needs no help from iceoryx2 and
//! works on what a process left that was killed at any moment.

use std::fs;
use std::io;
use std::path::{Path, PathBuf};

use super::lock::{self, Content};
use super::namespace::file_error;
use super::table_run::TableRun;
use super::{Namespace, SymbolError};

/// Where Linux shows POSIX shared memory as files.
const SHARED_MEMORY: &str = "/dev/shm";

/// What was removed.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Removed {
    /// The process that had ended without cleaning up, if it was written down.
    pub pid: Option<u32>,
    /// The files, folders and shared memories that are gone now.
    pub paths: Vec<PathBuf>,
}

impl Removed {
    /// Whether there was nothing to remove.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.paths.is_empty()
    }
}

/// Removes what a killed process left behind of `robot`. Refuses while the robot runs, and names
/// its process. Finding nothing is no error.
///
/// # Errors
/// If the robot runs, its name cannot be used, or a file cannot be removed.
pub fn remove_stale(robot: &str, place: &Namespace) -> Result<Removed, SymbolError> {
    place.check(robot)?;
    let Some(root) = place.existing_root()? else {
        return Ok(Removed::default());
    };
    let path = lock::instance_path(&root, robot);
    let existed = path.exists();
    let file = lock::lock_exclusively(robot, &path)?;
    let dead = lock::read_content(&file).unwrap_or_default();
    let result = remove_runs(&root, robot, dead);
    // Removed while the lock is held, so that no new owner can lose its file.
    fs::remove_file(&path).map_err(file_error("remove", &path))?;
    let mut removed = result?;
    if existed {
        removed.paths.push(path);
    }
    Ok(removed)
}

/// As [`remove_stale`] for every robot that left something in `place` and does not run: for who looks after a folder whose
/// processes were killed.
///
/// # Errors
/// If the folder cannot be used or a file cannot be removed.
pub fn remove_all_stale(place: &Namespace) -> Result<Vec<Removed>, SymbolError> {
    let Some(root) = place.existing_root()? else {
        return Ok(Vec::new());
    };
    let mut removed = Vec::new();
    for name in list(&root).map_err(file_error("list", &root))? {
        let Some(robot) = lock::robot_of(&name) else {
            continue;
        };
        match remove_stale(robot, place) {
            Ok(of_robot) => removed.push(of_robot),
            Err(SymbolError::AlreadyRuns { .. }) => {}
            Err(error) => return Err(error),
        }
    }
    Ok(removed)
}

/// Removes all runs of `robot` that left a folder, and the one that `dead` names. The caller holds
/// the robot's lock.
pub(super) fn remove_runs(root: &Path, robot: &str, dead: Content) -> Result<Removed, SymbolError> {
    let mut words = left_words(root, robot).map_err(file_error("list", root))?;
    words.extend(dead.word);
    words.sort();
    words.dedup();
    let mut removed = Removed {
        pid: dead.pid,
        paths: Vec::new(),
    };
    for word in words {
        removed
            .paths
            .extend(remove_run(&TableRun::of(root, robot, &word))?);
    }
    Ok(removed)
}

/// Removes the shared memory and the folder of one run.
pub(super) fn remove_run(run: &TableRun) -> Result<Vec<PathBuf>, SymbolError> {
    let mut removed = Vec::new();
    let shared_memory = Path::new(SHARED_MEMORY);
    let mark = format!("{}_", run.word);
    let names = list(shared_memory).map_err(file_error("list", shared_memory))?;
    for name in names.iter().filter(|name| name.contains(&mark)) {
        let path = shared_memory.join(name);
        match fs::remove_file(&path) {
            // Another user's, who has taken a name of this kind to keep the robot from starting.
            Err(error) if error.kind() == io::ErrorKind::PermissionDenied => {}
            result => {
                if gone(result).map_err(file_error("remove", &path))? {
                    removed.push(path);
                }
            }
        }
    }
    let folder = run.folder();
    if gone(fs::remove_dir_all(&folder)).map_err(file_error("remove", &folder))? {
        removed.push(folder);
    }
    Ok(removed)
}

/// The words of the runs of `robot` whose folders exist.
fn left_words(root: &Path, robot: &str) -> io::Result<Vec<String>> {
    let mut words = list(root)?;
    words.retain_mut(|name| {
        let word = name
            .strip_prefix(robot)
            .and_then(|rest| rest.strip_prefix('.'))
            .filter(|word| TableRun::is_word(word))
            .map(str::to_owned);
        *name = word.unwrap_or_default();
        !name.is_empty()
    });
    Ok(words)
}

fn list(folder: &Path) -> io::Result<Vec<String>> {
    let entries = match fs::read_dir(folder) {
        Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(Vec::new()),
        entries => entries?,
    };
    let mut names = Vec::new();
    for entry in entries {
        // Names that are not plain text are not ours.
        names.extend(entry?.file_name().into_string().ok());
    }
    Ok(names)
}

/// Whether this removal removed something; that somebody else did it first is no error.
fn gone(result: io::Result<()>) -> io::Result<bool> {
    match result {
        Ok(()) => Ok(true),
        Err(error) if error.kind() == io::ErrorKind::NotFound => Ok(false),
        Err(error) => Err(error),
    }
}
