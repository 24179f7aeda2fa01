//! Tests with whole robots take turns: one robot for each core, or one fleet, at a time. More of them starve each other.

use std::fs::{File, TryLockError};
use std::path::PathBuf;
use std::time::Duration;

const LOOK: Duration = Duration::from_millis(50);

/// While it lives, tests that need its room wait, in this program and in others.
pub struct Turn {
    _rooms: Vec<File>,
}

impl Turn {
    /// Waits for the room of one robot.
    pub fn of_a_robot() -> Self {
        let mut rooms: Vec<(PathBuf, File)> = rooms().collect();
        loop {
            for room in 0..rooms.len() {
                let (path, file) = &rooms[room];
                match file.try_lock() {
                    Ok(()) => {
                        let (_, file) = rooms.swap_remove(room);
                        return Self { _rooms: vec![file] };
                    }
                    Err(TryLockError::WouldBlock) => {}
                    Err(TryLockError::Error(error)) => {
                        panic!("{} cannot be locked: {error}", path.display())
                    }
                }
            }
            std::thread::sleep(LOOK);
        }
    }

    /// Waits for the whole machine.
    pub fn of_a_fleet() -> Self {
        // Always in the same order, so that two who wait do not wait for each other.
        let all = rooms().map(|(path, file)| {
            file.lock()
                .unwrap_or_else(|error| panic!("{} cannot be locked: {error}", path.display()));
            file
        });
        Self {
            _rooms: all.collect(),
        }
    }
}

/// One file for each core.
fn rooms() -> impl Iterator<Item = (PathBuf, File)> {
    let cores = std::thread::available_parallelism().map_or(1, usize::from);
    (0..cores).map(|core| {
        let path = std::env::temp_dir().join(format!("rig-tests-take-turns-{core}"));
        let file = File::options()
            .create(true)
            .truncate(false)
            .write(true)
            .open(&path)
            .unwrap_or_else(|error| panic!("{} cannot be opened: {error}", path.display()));
        (path, file)
    })
}
