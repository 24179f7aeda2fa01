//! Where a stepped robot leaves its checkpoint: memory that outlives its process.

use std::io;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use onboard::process::checkpoints::CheckpointStore;

/// The newest checkpoint of one robot; clones share it.
#[derive(Clone, Debug, Default)]
pub struct Checkpoints(Arc<Mutex<Vec<u8>>>);

impl Checkpoints {
    fn bytes(&self) -> MutexGuard<'_, Vec<u8>> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl CheckpointStore for Checkpoints {
    fn save(&mut self, bytes: &[u8]) -> io::Result<()> {
        let mut own = self.bytes();
        own.clear();
        own.extend_from_slice(bytes);
        Ok(())
    }

    fn take(&mut self) -> io::Result<Option<Vec<u8>>> {
        let bytes = std::mem::take(&mut *self.bytes());
        Ok(Some(bytes).filter(|bytes| !bytes.is_empty()))
    }
}
