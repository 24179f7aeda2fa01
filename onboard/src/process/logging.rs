//! Lines of the log go to standard error, on a thread of their own: a terminal that was stopped, a full pipe or disk holds up
//! nobody else. What cannot be written is dropped and counted.

use std::io::IsTerminal;

use tracing_appender::non_blocking::{ErrorCounter, NonBlockingBuilder, WorkerGuard};
use tracing_subscriber::EnvFilter;

/// Lines that may wait to be written.
const WAITING: usize = 4096;

/// The log while the program runs. When it is dropped, what waits is written out, for a second at most.
#[derive(Debug)]
pub struct Logging {
    unwritten: ErrorCounter,
    _worker: WorkerGuard,
}

impl Logging {
    /// Starts the thread, and has everything that is logged from now on go there.
    #[must_use]
    pub fn start() -> Self {
        let filter = EnvFilter::try_from_env("ONBOARD_LOG")
            .unwrap_or_else(|_| EnvFilter::new("info,zenoh=error,ethercrab=warn"));
        let (writer, worker) = NonBlockingBuilder::default()
            .buffered_lines_limit(WAITING)
            .lossy(true)
            .thread_name("log")
            .finish(std::io::stderr());
        let unwritten = writer.error_counter();
        // A test that runs two robots in one process has one already.
        let _ = tracing_subscriber::fmt()
            .with_env_filter(filter)
            .with_writer(writer)
            .with_ansi(std::io::stderr().is_terminal())
            .with_target(false)
            // A closed pipe must not stop a robot.
            .log_internal_errors(false)
            .try_init();
        Self {
            unwritten,
            _worker: worker,
        }
    }

    /// Counts the lines that could not be written.
    #[must_use]
    pub fn unwritten(&self) -> ErrorCounter {
        self.unwritten.clone()
    }
}
