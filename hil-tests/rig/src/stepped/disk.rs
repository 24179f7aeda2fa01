//! The disk below the mediator's journal: memory that outlives the mediator that wrote it.

use std::io;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use redb::StorageBackend;
use sim::world::Random;

/// Disks write so many bytes or none of them.
const SECTOR_BYTES: usize = 512;

/// The bytes of a file; clones share them.
#[derive(Clone, Debug, Default)]
pub(super) struct Disk {
    file: Arc<Mutex<File>>,
    /// It takes nothing.
    full: Arc<AtomicBool>,
}

/// What the file holds, and how it was when it was synced last.
#[derive(Clone, Debug, Default)]
struct File {
    bytes: Vec<u8>,
    /// How long it was.
    synced_length: usize,
    /// What was written over since then, in that order: where it began, and what was there.
    before: Vec<(usize, Vec<u8>)>,
    /// What was done since then, in that order.
    since: Vec<Operation>,
    cut: Option<Cut>,
}

#[derive(Clone, Debug)]
enum Operation {
    /// These bytes, from here on.
    Write(usize, Vec<u8>),
    /// The file has this length.
    SetLength(usize),
}

/// The end of who writes, while it writes.
#[derive(Clone, Debug)]
struct Cut {
    /// After so many operations.
    after: u32,
    how: End,
    /// What it leaves, from then on; what is written afterwards nobody has written.
    left: Option<Vec<u8>>,
}

/// How who writes ends.
#[derive(Clone, Debug)]
pub(super) enum End {
    /// Its process is killed.
    Killed,
    /// Its computer loses its power; what was not synced is on the disk or not, by chance.
    PowerLost(Random),
}

impl File {
    /// From here on it will be written over, or cut off.
    fn keep(&mut self, place: std::ops::Range<usize>) {
        if let Some(bytes) = self.bytes.get(place.start..place.end.min(self.bytes.len())) {
            self.before.push((place.start, bytes.to_vec()));
        }
    }

    fn sync(&mut self) {
        self.synced_length = self.bytes.len();
        self.before.clear();
        self.since.clear();
    }

    /// Something is about to be done.
    fn begin(&mut self) {
        let Some(mut cut) = self.cut.take() else {
            return;
        };
        if cut.after > 0 {
            cut.after -= 1;
        } else if cut.left.is_none() {
            cut.left = Some(match &mut cut.how {
                End::Killed => self.bytes.clone(),
                End::PowerLost(chance) => self.partly_synced(chance),
            });
        }
        self.cut = Some(cut);
    }

    /// As it was when it was synced last, with some of what was done since.
    fn partly_synced(&self, chance: &mut Random) -> Vec<u8> {
        let mut bytes = self.synced();
        let mut is_done = || chance.unit() < 0.5;
        for operation in &self.since {
            match operation {
                Operation::SetLength(length) => bytes.resize(*length, 0),
                Operation::Write(start, data) => {
                    for (sector, data) in data.chunks(SECTOR_BYTES).enumerate() {
                        let start = start + sector * SECTOR_BYTES;
                        if is_done() {
                            bytes[start..start + data.len()].copy_from_slice(data);
                        }
                    }
                }
            }
        }
        bytes
    }

    /// As it was when it was synced last.
    fn synced(&self) -> Vec<u8> {
        let mut bytes = self.bytes.clone();
        for (start, before) in self.before.iter().rev() {
            let end = start + before.len();
            bytes.resize(bytes.len().max(end), 0);
            bytes[*start..end].copy_from_slice(before);
        }
        bytes.resize(self.synced_length, 0);
        bytes
    }
}

impl Disk {
    fn with(bytes: Vec<u8>) -> Self {
        let mut file = File {
            bytes,
            ..File::default()
        };
        file.sync();
        Self {
            file: Arc::new(Mutex::new(file)),
            full: Arc::default(),
        }
    }

    /// What a crash of the process at this moment leaves: all that it has written.
    pub(super) fn copy(&self) -> Self {
        Self::with(self.file().bytes.clone())
    }

    /// What a loss of power leaves at worst: all that was synced.
    pub(super) fn synced(&self) -> Self {
        Self::with(self.file().synced())
    }

    /// Who writes to it ends after so many operations from now on.
    pub(super) fn cut(&self, after: u32, how: End) {
        self.file().cut = Some(Cut {
            after,
            how,
            left: None,
        });
    }

    /// What that has left, once it has come to it.
    pub(super) fn left(&self) -> Option<Self> {
        let over = self.file().cut.take_if(|cut| cut.left.is_some());
        over.and_then(|cut| cut.left).map(Self::with)
    }

    /// Whether it takes nothing from now on.
    pub(super) fn fill(&self, full: bool) {
        self.full.store(full, Ordering::Relaxed);
    }

    fn check_room(&self) -> io::Result<()> {
        if self.full.load(Ordering::Relaxed) {
            return Err(io::ErrorKind::StorageFull.into());
        }
        Ok(())
    }

    fn file(&self) -> MutexGuard<'_, File> {
        self.file.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

fn range(offset: u64, length: usize, of: usize) -> io::Result<std::ops::Range<usize>> {
    let outside = || io::Error::from(io::ErrorKind::UnexpectedEof);
    let start = usize::try_from(offset).map_err(|_| outside())?;
    let end = start.checked_add(length).filter(|end| *end <= of);
    Ok(start..end.ok_or_else(outside)?)
}

impl StorageBackend for Disk {
    fn len(&self) -> io::Result<u64> {
        Ok(self.file().bytes.len() as u64)
    }

    fn read(&self, offset: u64, out: &mut [u8]) -> io::Result<()> {
        let file = self.file();
        out.copy_from_slice(&file.bytes[range(offset, out.len(), file.bytes.len())?]);
        Ok(())
    }

    fn set_len(&self, length: u64) -> io::Result<()> {
        self.check_room()?;
        let length = usize::try_from(length).map_err(|_| io::ErrorKind::OutOfMemory)?;
        let mut file = self.file();
        file.begin();
        let end = file.bytes.len();
        file.keep(length..end);
        file.since.push(Operation::SetLength(length));
        file.bytes.resize(length, 0);
        Ok(())
    }

    fn sync_data(&self) -> io::Result<()> {
        let mut file = self.file();
        file.begin();
        file.sync();
        Ok(())
    }

    fn write(&self, offset: u64, data: &[u8]) -> io::Result<()> {
        self.check_room()?;
        let mut file = self.file();
        let place = range(offset, data.len(), file.bytes.len())?;
        file.begin();
        file.keep(place.clone());
        file.since
            .push(Operation::Write(place.start, data.to_vec()));
        file.bytes[place].copy_from_slice(data);
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_loss_of_power_leaves_what_was_synced_and_a_crash_all_that_was_written() {
        let disk = Disk::default();
        let bytes = |disk: &Disk| disk.file().bytes.clone();
        let write = |at, data: &[u8]| disk.write(at, data).expect("there is room");
        disk.set_len(4).expect("there is room");
        write(0, b"abcd");
        assert_eq!(bytes(&disk.synced()), b"");
        disk.sync_data().expect("synced");
        // Twice in one place, shorter, longer, and beyond the old end.
        write(1, b"xy");
        write(2, b"z");
        disk.set_len(2).expect("there is room");
        disk.set_len(6).expect("there is room");
        write(3, b"123");
        assert_eq!(bytes(&disk.copy()), b"ax\x00123");
        assert_eq!(bytes(&disk.synced()), b"abcd");
        // What it leaves is on the disk of whoever starts from there.
        assert_eq!(bytes(&disk.copy().synced()), b"ax\x00123");
        disk.sync_data().expect("synced");
        assert_eq!(bytes(&disk.synced()), b"ax\x00123");
    }

    #[test]
    fn who_ends_while_it_writes_leaves_what_it_had_written_or_by_chance_a_part_of_what_it_had_not_synced()
     {
        let length = 4 * SECTOR_BYTES;
        let left = |seed: Option<u64>, after| {
            let disk = Disk::default();
            disk.set_len(length as u64).expect("there is room");
            disk.sync_data().expect("synced");
            disk.cut(
                after,
                seed.map_or(End::Killed, |seed| End::PowerLost(Random::new(seed, 1))),
            );
            for byte in 1..=2 {
                disk.write(0, &vec![byte; length]).expect("there is room");
            }
            disk.sync_data().expect("synced");
            let left = disk.left().expect("it is over");
            assert!(disk.left().is_none(), "once");
            let bytes = left.file().bytes.clone();
            assert_eq!(bytes.len(), length);
            let sectors = bytes.chunks(SECTOR_BYTES);
            sectors.map(|own| own[0]).collect::<Vec<_>>()
        };
        assert_eq!(left(None, 0), [0; 4]);
        assert_eq!(left(None, 1), [1; 4]);
        assert_eq!(left(None, 2), [2; 4]);
        let mut seen = std::collections::BTreeSet::new();
        for seed in 0..100 {
            assert_eq!(left(Some(seed), 0), [0; 4]);
            seen.extend(left(Some(seed), 2));
        }
        assert_eq!(seen.into_iter().collect::<Vec<_>>(), [0, 1, 2]);
    }
}
