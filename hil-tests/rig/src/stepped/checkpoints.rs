//! Where a stepped robot leaves its checkpoint: memory that outlives its process.

use std::io;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use onboard::process::checkpoints::{CheckpointStore, Ended, Inheritance, Journey};

/// The newest checkpoint of one robot, and the note on its disk; clones share them.
#[derive(Clone, Debug, Default)]
pub struct Checkpoints(Arc<Mutex<Kept>>);

#[derive(Debug, Default)]
struct Kept {
    bytes: Vec<u8>,
    journey: Journey,
    is_full: bool,
}

impl Checkpoints {
    fn kept(&self) -> MutexGuard<'_, Kept> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// The robot's computer starts anew: only what is on disk remains.
    pub fn lose_memory(&self) {
        self.kept().bytes.clear();
    }

    /// Its disk is full, or has room again.
    pub fn fill(&self, is_full: bool) {
        self.kept().is_full = is_full;
    }
}

impl CheckpointStore for Checkpoints {
    fn save(&mut self, bytes: &[u8]) -> io::Result<()> {
        let mut own = self.kept();
        if own.is_full && own.journey != Journey::UnderWay {
            return Err(io::ErrorKind::StorageFull.into());
        }
        own.bytes.clear();
        own.bytes.extend_from_slice(bytes);
        own.journey = Journey::UnderWay;
        Ok(())
    }

    fn arrive(&mut self, ended: Ended) -> io::Result<()> {
        let mut own = self.kept();
        own.bytes.clear();
        own.journey = ended.into();
        Ok(())
    }

    fn is_noted(&self) -> bool {
        self.kept().journey == Journey::UnderWay
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
