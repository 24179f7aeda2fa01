//! The running mediator: two activities on two threads, and a bounded queue in each direction between them.
//!
//! *Management* owns manager and journal; it does nothing but one step after the other. *Communication* owns the network and
//! the control socket. A full queue drops what came last and counts it: levels come again.

mod communication;
mod folder;
mod management;
mod question;

pub use communication::Settings;
pub use folder::Folder;
pub use question::{Answer, Question, ask};

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::time::Instant;

use crate::journal::Store;
use crate::manager::Manager;

/// Reports and questions that may wait for management.
const INPUTS: usize = 1024;
/// Messages that may wait for communication.
const OUTPUTS: usize = 4096;

/// What both threads share.
#[derive(Debug)]
pub struct Shared {
    started: Instant,
    stop: AtomicBool,
    dropped_inputs: AtomicU64,
    dropped_outputs: AtomicU64,
}

impl Shared {
    fn new() -> Self {
        Self {
            started: Instant::now(),
            stop: AtomicBool::new(false),
            dropped_inputs: AtomicU64::new(0),
            dropped_outputs: AtomicU64::new(0),
        }
    }

    /// Nanoseconds since the start; nobody else's clock is ever compared with it.
    fn now_ns(&self) -> u64 {
        u64::try_from(self.started.elapsed().as_nanos()).unwrap_or(u64::MAX)
    }

    fn is_stopping(&self) -> bool {
        self.stop.load(Ordering::Acquire)
    }

    /// Makes both threads end.
    pub fn stop(&self) {
        self.stop.store(true, Ordering::Release);
    }
}

/// A mediator that runs until it is stopped.
pub struct Runtime {
    shared: Arc<Shared>,
    management: std::thread::JoinHandle<Result<(), String>>,
    communication: std::thread::JoinHandle<Result<(), String>>,
}

impl Runtime {
    /// Opens the network, then starts both threads.
    ///
    /// # Errors
    /// Why the network or the control socket cannot be opened.
    pub fn start(
        manager: Manager,
        store: Store,
        settings: Settings,
        folder: &Folder,
    ) -> Result<Self, String> {
        let shared = Arc::new(Shared::new());
        let (inputs, inbox) = std::sync::mpsc::sync_channel(INPUTS);
        let (outbox, outputs) = tokio::sync::mpsc::channel(OUTPUTS);
        let opened = communication::open(&settings, folder)?;
        let spawn = |name: &str| std::thread::Builder::new().name(name.to_owned());
        let management = {
            let shared = Arc::clone(&shared);
            spawn("management")
                .spawn(move || management::run(manager, &store, &inbox, &outbox, &shared))
        };
        let communication = {
            let shared = Arc::clone(&shared);
            spawn("communication")
                .spawn(move || communication::run(opened, &settings, inputs, outputs, &shared))
        };
        let failed = |error: std::io::Error| format!("a thread cannot be started: {error}");
        Ok(Self {
            shared,
            management: management.map_err(failed)?,
            communication: communication.map_err(failed)?,
        })
    }

    /// To stop it from a signal handler's thread.
    #[must_use]
    pub fn shared(&self) -> Arc<Shared> {
        Arc::clone(&self.shared)
    }

    /// Waits until it has ended.
    ///
    /// # Errors
    /// Why it had to end, such as a journal that cannot be written.
    pub fn join(self) -> Result<(), String> {
        let ended = |thread: std::thread::JoinHandle<_>, name| {
            thread
                .join()
                .unwrap_or_else(|_| Err(format!("thread {name} panicked; this is a bug")))
        };
        let management = ended(self.management, "management");
        let communication = ended(self.communication, "communication");
        management.and(communication)
    }
}
