//! Threads that work until they are dropped.

use std::io;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::{Builder, JoinHandle};

/// Some threads, which are told to end, and waited for, when this is dropped.
#[derive(Debug, Default)]
pub struct Threads {
    stop: Arc<AtomicBool>,
    threads: Vec<JoinHandle<()>>,
}

impl Threads {
    /// Starts one more. It works until it is told to stop, which it has to look at itself.
    ///
    /// # Errors
    /// The operating system's, when it has no thread to give.
    pub fn spawn(
        &mut self,
        name: String,
        work: impl FnOnce(&AtomicBool) + Send + 'static,
    ) -> io::Result<()> {
        let stop = Arc::clone(&self.stop);
        let thread = Builder::new().name(name).spawn(move || work(&stop))?;
        self.threads.push(thread);
        Ok(())
    }

    /// How many there are.
    #[must_use]
    pub fn count(&self) -> usize {
        self.threads.len()
    }
}

impl Drop for Threads {
    fn drop(&mut self) {
        self.stop.store(true, Ordering::Relaxed);
        for thread in self.threads.drain(..) {
            // A panic in it was said by the hook.
            let _ = thread.join();
        }
    }
}
