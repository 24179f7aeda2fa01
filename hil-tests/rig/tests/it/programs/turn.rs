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
        let _gate = (count > 1).then(gate);
        let mut own = Vec::with_capacity(count);
        while own.len() < count {
            let wanted = count - own.len();
            own.extend(rooms().filter(is_ours).take(wanted));
            if own.len() < count {
                std::thread::sleep(LOOK);
            }
        }
        Self { _rooms: own }
    }

    /// Waits until nobody else has any: for a test that keeps all others from their time.
    pub fn of_the_machine() -> Self {
        let gate = gate();
        let all = rooms().inspect(wait_for);
        Self {
            _rooms: std::iter::once(gate).chain(all).collect(),
        }
    }
}

/// One file for each robot that has room.
fn rooms() -> impl Iterator<Item = File> {
    let cores = std::thread::available_parallelism().map_or(1, usize::from);
    (0..cores * ROBOTS_PER_CORE).map(|room| file(&room.to_string()))
}

/// Who wants more than one room keeps what it has got, or those who want less would always be before it; so only one may wait like this.
fn gate() -> File {
    let gate = file("all");
    wait_for(&gate);
    gate
}

fn wait_for(room: &File) {
    if let Err(error) = room.lock() {
        panic!("a room cannot be locked: {error}");
    }
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
