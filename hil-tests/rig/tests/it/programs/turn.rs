//! Tests with whole robots take turns: three robots for each core at a time, whose threads take a tenth of it each. More of them starve
//! each other.

use std::fs::{File, TryLockError};
use std::time::Duration;

const ROBOTS_PER_CORE: usize = 3;
const LOOK: Duration = Duration::from_millis(50);

/// While it lives, tests that need its rooms wait, in this program and in others.
pub struct Turn {
    _rooms: Vec<File>,
}

impl Turn {
    /// Waits until there is room for so many robots, or until nobody else has any.
    pub fn of_robots(count: usize) -> Self {
        let count = count.min(rooms().count());
        loop {
            // All or none, so that two who wait do not wait for each other.
            let free: Vec<File> = rooms().filter(is_ours).take(count).collect();
            if free.len() == count {
                return Self { _rooms: free };
            }
            drop(free);
            std::thread::sleep(LOOK);
        }
    }

    /// Waits until nobody else has any: for a test that keeps all others from their time.
    pub fn of_the_machine() -> Self {
        // It keeps what it has got, or those who want less would always be before it; so only one may wait like this.
        let gate = std::iter::once_with(|| file("all"));
        let all = gate.chain(rooms()).inspect(|room| {
            if let Err(error) = room.lock() {
                panic!("a room cannot be locked: {error}");
            }
        });
        Self {
            _rooms: all.collect(),
        }
    }
}

/// One file for each robot that has room.
fn rooms() -> impl Iterator<Item = File> {
    let cores = std::thread::available_parallelism().map_or(1, usize::from);
    (0..cores * ROBOTS_PER_CORE).map(|room| file(&room.to_string()))
}

fn file(name: &str) -> File {
    let path = std::env::temp_dir().join(format!("rig-tests-take-turns-{name}"));
    let mut options = File::options();
    let room = options.create(true).truncate(false).write(true).open(&path);
    room.unwrap_or_else(|error| panic!("{} cannot be opened: {error}", path.display()))
}

/// Locks it, if nobody has.
fn is_ours(room: &File) -> bool {
    match room.try_lock() {
        Ok(()) => true,
        Err(TryLockError::WouldBlock) => false,
        Err(TryLockError::Error(error)) => panic!("a room cannot be locked: {error}"),
    }
}
