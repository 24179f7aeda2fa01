//! Whole robots take turns: two of them at once starve each other on a small machine.

use std::fs::File;
use std::sync::{Mutex, MutexGuard, PoisonError};

static IN_THIS_PROGRAM: Mutex<()> = Mutex::new(());

/// While it lives no other test that asked for a turn runs, in this program or in another.
pub struct Turn {
    // Released first, so that the file is never waited for with the mutex free.
    _file: File,
    _mutex: MutexGuard<'static, ()>,
}

impl Turn {
    /// Waits for it.
    pub fn take() -> Self {
        let mutex = IN_THIS_PROGRAM
            .lock()
            .unwrap_or_else(PoisonError::into_inner);
        let path = std::env::temp_dir().join("rig-tests-take-turns");
        let file = File::options()
            .create(true)
            .truncate(false)
            .write(true)
            .open(&path)
            .unwrap_or_else(|error| panic!("{} cannot be opened: {error}", path.display()));
        file.lock()
            .unwrap_or_else(|error| panic!("{} cannot be locked: {error}", path.display()));
        Self {
            _file: file,
            _mutex: mutex,
        }
    }
}
