//! The log queue: threads put lines in, the supervisor writes them out.
//!
//! Real-time threads in state *running* report through their activity's port, which allocates nothing; lines of text are for
//! the states in which the rules are suspended. A full queue drops the line and counts it.

use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::mpsc::{Receiver, SyncSender, sync_channel};

use contract::logging::ErrorCounter;

/// Lines that may wait for the supervisor.
const CAPACITY: usize = 256;

/// Severity of a line.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Level {
    /// For the record.
    Info,
    /// Something to look at.
    Warn,
    /// Something is broken.
    Error,
}

/// Puts lines into the queue; never waits.
#[derive(Clone, Debug)]
pub struct LogSender {
    lines: SyncSender<(Level, String)>,
    dropped: Arc<AtomicU64>,
}

/// Takes lines out of the queue.
#[derive(Debug)]
pub struct LogDrain {
    lines: Receiver<(Level, String)>,
    dropped: Arc<AtomicU64>,
    /// Counts lines that were taken out and not written.
    unwritten: Option<ErrorCounter>,
    told: usize,
}

/// A queue of log lines.
#[must_use]
pub fn queue() -> (LogSender, LogDrain) {
    let (sender, receiver) = sync_channel(CAPACITY);
    let dropped = Arc::<AtomicU64>::default();
    (
        LogSender {
            lines: sender,
            dropped: Arc::clone(&dropped),
        },
        LogDrain {
            lines: receiver,
            dropped,
            unwritten: None,
            told: 0,
        },
    )
}

impl LogSender {
    /// A line for the record.
    pub fn info(&self, line: impl Into<String>) {
        self.send(Level::Info, line.into());
    }

    /// A line to look at.
    pub fn warn(&self, line: impl Into<String>) {
        self.send(Level::Warn, line.into());
    }

    /// A line about something broken.
    pub fn error(&self, line: impl Into<String>) {
        self.send(Level::Error, line.into());
    }

    fn send(&self, level: Level, line: String) {
        if self.lines.try_send((level, line)).is_err() {
            self.dropped.fetch_add(1, Ordering::Relaxed);
        }
    }
}

/// Says why an attempt failed, once for each different reason until it succeeds.
#[derive(Debug, Default)]
pub struct Complaints {
    last: String,
}

impl Complaints {
    /// Logs `what` and `why`, unless that was the last complaint.
    pub fn say(&mut self, log: &LogSender, what: &str, why: String) {
        if why != self.last {
            log.warn(format!("{what}: {why}; trying again"));
            self.last = why;
        }
    }

    /// The attempt succeeded.
    pub fn forget(&mut self) {
        self.last.clear();
    }
}

impl LogDrain {
    /// Tells of lines that were not written, too.
    #[must_use]
    pub fn counting(self, unwritten: ErrorCounter) -> Self {
        Self {
            unwritten: Some(unwritten),
            ..self
        }
    }

    /// Writes out every waiting line.
    pub fn drain(&mut self) {
        while let Ok((level, line)) = self.lines.try_recv() {
            match level {
                Level::Info => tracing::info!("{line}"),
                Level::Warn => tracing::warn!("{line}"),
                Level::Error => tracing::error!("{line}"),
            }
        }
        let dropped = self.dropped.swap(0, Ordering::Relaxed);
        if dropped > 0 {
            tracing::warn!("{dropped} log lines were dropped: the queue was full");
        }
        let unwritten = { self.unwritten.as_ref() }.map_or(0, ErrorCounter::dropped_lines);
        let new = unwritten - std::mem::replace(&mut self.told, unwritten);
        if new > 0 {
            // Lost as well while nothing is taken; the number is in the next such line then.
            tracing::warn!("{new} log lines were lost: standard error took none");
        }
    }
}
