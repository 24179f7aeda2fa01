//! Work of no importance on every core, as other programs of a robot's computer make it.

use std::fs::File;
use std::hint::black_box;
use std::io::{Seek, SeekFrom, Write};
use std::sync::atomic::Ordering;
use std::time::Duration;

use onboard::cli::Failure;

use super::place::cores;
use crate::folder::Folder;
use crate::threads::Threads;

/// More than the caches of a core hold.
const COPIED_BYTES: usize = 16 << 20;
/// Written at a time,
const WRITTEN_BYTES: usize = 1 << 20;
/// and so often: a log that floods, but no more than a memory card bears for an hour.
const WRITES: Duration = Duration::from_millis(100);

/// Loads the machine until it is dropped, all threads without priority: for each core one that copies memory, and one for all that
/// writes to disk.
pub struct Load {
    threads: Threads,
    // Has the file that is written.
    _folder: Folder,
}

impl Load {
    /// Begins.
    ///
    /// # Errors
    /// [`Failure`] when the system has no threads or no place for a file.
    pub fn begin() -> Result<Self, Failure> {
        let folder = Folder::new()?;
        let mut file = File::create_new(folder.path().join("load")).map_err(Failure::refused)?;
        let mut load = Self {
            threads: Threads::default(),
            _folder: folder,
        };
        for _ in cores() {
            load.spawn(|| {
                let from = vec![1_u8; COPIED_BYTES];
                let mut to = vec![0_u8; COPIED_BYTES];
                move || black_box(&mut to).copy_from_slice(black_box(&from))
            })?;
        }
        load.spawn(move || {
            let bytes = vec![1_u8; WRITTEN_BYTES];
            move || {
                // A disk that is full is no load: nothing is measured of it.
                let _ = file.seek(SeekFrom::Start(0));
                let _ = file.write_all(&bytes).and_then(|()| file.sync_data());
                std::thread::sleep(WRITES);
            }
        })?;
        Ok(load)
    }

    fn spawn<W: FnMut()>(
        &mut self,
        make: impl FnOnce() -> W + Send + 'static,
    ) -> Result<(), Failure> {
        let works = self.threads.spawn("load".to_owned(), move |stop| {
            let mut work = make();
            while !stop.load(Ordering::Relaxed) {
                work();
            }
        });
        works.map_err(Failure::failed)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_load_ends_and_leaves_nothing() {
        let load = Load::begin().unwrap_or_else(|failure| panic!("{failure:?}"));
        assert_eq!(load.threads.count(), cores().len() + 1);
        let folder = load._folder.path().to_owned();
        assert!(folder.join("load").exists());
        drop(load);
        assert!(!folder.exists());
    }
}
