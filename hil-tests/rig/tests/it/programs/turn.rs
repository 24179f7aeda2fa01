//! Tests with whole robots take turns: three robots for each core at a time, whose threads take a tenth of it each. More of them starve
//! each other.

use std::fs::{File, TryLockError};
use std::time::Duration;

use crate::programs::late::note_turn;

const ROBOTS_PER_CORE: usize = 3;
const LOOK: Duration = Duration::from_millis(50);

/// While it lives, tests that need its rooms wait, in this program and in others.
pub struct Turn {
    _rooms: Vec<File>,
    _machine: File,
}

impl Turn {
    /// Waits until there is room for so many robots, or until nobody else has any, and while tests wait that take longer.
    pub fn of_robots(count: usize) -> Self {
        // Free once those that take longer have their rooms.
        drop(exclusive("long"));
        Self::of_rooms(count)
    }

    /// The same for a test that takes a minute: all are done sooner if such tests begin first.
    pub fn of_robots_for_long(count: usize) -> Self {
        let _first = shared("long");
        Self::of_rooms(count)
    }

    /// Waits until nobody else has a room, nor waits for one: for a test that keeps all others from their time.
    pub fn of_the_machine() -> Self {
        Self::taken(Vec::new(), exclusive("machine"))
    }

    fn of_rooms(count: usize) -> Self {
        let count = count.min(rooms().count());
        let machine = shared("machine");
        // Only one looks for rooms, and keeps what it has got: those who want few would always be before one who wants many.
        let _gate = exclusive("gate");
        let mut own = Vec::with_capacity(count);
        while own.len() < count {
            let wanted = count - own.len();
            own.extend(rooms().filter(is_ours).take(wanted));
            if own.len() < count {
                std::thread::sleep(LOOK);
            }
        }
        Self::taken(own, machine)
    }

    fn taken(rooms: Vec<File>, machine: File) -> Self {
        note_turn();
        Self {
            _rooms: rooms,
            _machine: machine,
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

fn exclusive(name: &str) -> File {
    let file = file(name);
    file.lock().expect("a file can be locked");
    file
}

fn shared(name: &str) -> File {
    let file = file(name);
    file.lock_shared().expect("a file can be locked");
    file
}

/// Locks it, if nobody has.
fn is_ours(room: &File) -> bool {
    match room.try_lock() {
        Ok(()) => true,
        Err(TryLockError::WouldBlock) => false,
        Err(TryLockError::Error(error)) => panic!("a room cannot be locked: {error}"),
    }
}
