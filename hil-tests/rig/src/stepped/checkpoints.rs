//! Where a stepped robot leaves its checkpoint: memory that outlives its process.

use std::io;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use onboard::composition::checkpoint::Checkpoint;
use onboard::process::checkpoints::{CheckpointStore, Ended, Inheritance, Journey, UNATTENDED};

/// The newest checkpoint of one robot, and the note on its disk; clones share them, one for each of its processes.
#[derive(Clone, Debug, Default)]
pub struct Checkpoints {
    kept: Arc<Mutex<Kept>>,
    /// This process has noted that the robot is under way.
    noted: bool,
    /// How many were kept when it was looked last that they are, and since when; none once what they have become is kept.
    seen: (u64, Option<u64>),
}

#[derive(Debug, Default)]
struct Kept {
    bytes: Vec<u8>,
    saves: u64,
    journey: Journey,
    is_full: bool,
}

impl Kept {
    /// Writes the note anew, whatever it says already.
    fn note(&mut self, journey: Journey) -> io::Result<()> {
        if self.is_full && journey != Journey::None {
            return Err(io::ErrorKind::StorageFull.into());
        }
        self.journey = journey;
        Ok(())
    }
}

impl Checkpoints {
    fn kept(&self) -> MutexGuard<'_, Kept> {
        self.kept.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// The robot's computer starts anew: only what is on disk remains.
    pub fn lose_memory(&self) {
        self.kept().bytes.clear();
    }

    /// What the thread that keeps them does when none comes any more.
    pub(super) fn attend(&mut self, now_ns: u64) {
        let mut own = self.kept.lock().unwrap_or_else(PoisonError::into_inner);
        if own.saves != self.seen.0 {
            self.seen = (own.saves, Some(now_ns));
        }
        let late = |since_ns: &mut u64| u128::from(now_ns - *since_ns) > UNATTENDED.as_nanos();
        if self.seen.1.take_if(late).is_some()
            && let Some(left) = Checkpoint::unattended(&own.bytes)
        {
            own.bytes = left;
        }
    }

    /// Its disk is full, or has room again.
    pub fn fill(&self, is_full: bool) {
        self.kept().is_full = is_full;
    }
}

impl CheckpointStore for Checkpoints {
    fn save(&mut self, bytes: &[u8]) -> io::Result<()> {
        let mut own = self.kept.lock().unwrap_or_else(PoisonError::into_inner);
        if !self.noted {
            own.note(Journey::UnderWay)?;
            self.noted = true;
        }
        // In memory, whatever the disk is like.
        own.bytes.clear();
        own.bytes.extend_from_slice(bytes);
        own.saves += 1;
        Ok(())
    }

    fn arrive(&mut self, ended: Ended) -> io::Result<()> {
        let mut own = self.kept.lock().unwrap_or_else(PoisonError::into_inner);
        own.note(ended.into())?;
        self.noted = false;
        own.bytes.clear();
        Ok(())
    }

    fn is_noted(&self) -> bool {
        self.noted
    }
}

impl Inheritance for Checkpoints {
    fn journey(&mut self) -> io::Result<Journey> {
        Ok(self.kept().journey.clone())
    }

    fn take(&mut self) -> io::Result<Option<Vec<u8>>> {
        let bytes = std::mem::take(&mut self.kept().bytes);
        Ok(Some(bytes).filter(|bytes| !bytes.is_empty()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_process_notes_anew_and_a_full_disk_leaves_what_the_one_before_has_noted() {
        let mut before = Checkpoints::default();
        let mut next = before.clone();
        before.save(b"there").expect("there is room");
        before.fill(true);
        before.save(b"here").expect("it is noted already");
        before
            .arrive(Ended::default())
            .expect("there is nothing to write");
        assert_eq!(next.journey().expect("readable"), Journey::None);
        before.fill(false);
        before.save(b"here").expect("there is room");
        next.fill(true);
        assert_eq!(
            next.take().expect("readable").as_deref(),
            Some(&b"here"[..])
        );
        next.save(b"further").expect_err("it is full");
        assert!(before.is_noted() && !next.is_noted());
        assert_eq!(next.journey().expect("readable"), Journey::UnderWay);
        assert_eq!(next.take().expect("readable"), None);
        next.fill(false);
        next.save(b"further").expect("there is room");
        assert!(next.is_noted());
    }
}
