//! Threads that measure: each is new, so that its priority ends with it.

use std::thread::{Builder, JoinHandle};

use onboard::cli::Failure;

/// A thread that measures.
pub struct Measuring<T>(JoinHandle<Result<T, Failure>>);

impl<T: Send + 'static> Measuring<T> {
    /// Starts it.
    ///
    /// # Errors
    /// [`Failure::Failed`] when the system has no thread to give.
    pub fn spawn(
        name: &str,
        work: impl FnOnce() -> Result<T, Failure> + Send + 'static,
    ) -> Result<Self, Failure> {
        let thread = Builder::new().name(name.to_owned()).spawn(work);
        Ok(Self(thread.map_err(Failure::failed)?))
    }

    /// What it has measured, once it ends.
    ///
    /// # Errors
    /// That of its work, or [`Failure::Failed`] when that panicked.
    pub fn end(self) -> Result<T, Failure> {
        let panicked = |_| Err(Failure::failed("a measuring thread panicked"));
        self.0.join().unwrap_or_else(panicked)
    }
}
