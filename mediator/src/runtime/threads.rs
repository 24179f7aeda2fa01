//! Starts both threads, and waits for their end.

use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::sync::mpsc::{Receiver, RecvTimeoutError};
use std::time::Duration;

use super::communication::{self, Settings};
use super::folder::Folder;
use super::management::{Input, Management, TICK_NS};
use super::shared::Shared;
use crate::journal::Store;
use crate::manager::Manager;
use contract::wire::MediatorReport;
use tokio::sync::mpsc::Sender;
use tokio::sync::mpsc::error::TrySendError;

/// Reports and questions that may wait for management.
pub const INPUTS: usize = 1024;
/// Messages that may wait for communication.
pub const OUTPUTS: usize = 4096;

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
            spawn("management").spawn(move || manage(manager, store, &inbox, &outbox, &shared))
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

/// Runs until it is told to stop, or the journal fails: nothing is granted that is not written down first.
fn manage(
    manager: Manager,
    store: Store,
    inbox: &Receiver<Input>,
    outbox: &Sender<MediatorReport>,
    shared: &Shared,
) -> Result<(), String> {
    let outcome = manage_until_stopped(manager, store, inbox, outbox, shared);
    shared.stop();
    outcome
}

fn manage_until_stopped(
    manager: Manager,
    store: Store,
    inbox: &Receiver<Input>,
    outbox: &Sender<MediatorReport>,
    shared: &Shared,
) -> Result<(), String> {
    let mut management = Management::start(manager, store).map_err(|error| error.to_string())?;
    let mut overflows = Overflows::default();
    while !shared.is_stopping() {
        let first = match inbox.recv_timeout(Duration::from_nanos(TICK_NS)) {
            Ok(input) => Some(input),
            Err(RecvTimeoutError::Timeout) => None,
            Err(RecvTimeoutError::Disconnected) => break,
        };
        let now_ns = shared.now_ns();
        management
            .turn(first.into_iter().chain(inbox.try_iter()), now_ns)
            .map_err(|error| error.to_string())?;
        overflows.tell(shared, now_ns);
        while let Some(message) = management.next_message(now_ns) {
            match outbox.try_send(message) {
                Ok(()) => {}
                Err(TrySendError::Full(_)) => {
                    shared.dropped_outputs.fetch_add(1, Ordering::Relaxed);
                }
                Err(TrySendError::Closed(_)) => return Ok(()),
            }
        }
        management.answer();
    }
    Ok(())
}

/// What was dropped because a queue was full; logged at most once a second.
#[derive(Default)]
struct Overflows {
    told: [u64; 2],
    again_ns: u64,
}

impl Overflows {
    fn tell(&mut self, shared: &Shared, now_ns: u64) {
        let dropped = [&shared.dropped_inputs, &shared.dropped_outputs];
        let dropped = dropped.map(|count| count.load(Ordering::Relaxed));
        if dropped == self.told || now_ns < self.again_ns {
            return;
        }
        let [reports, messages] = dropped;
        tracing::warn!(
            "overload: {reports} reports and {messages} messages dropped since the start; each is sent again with the next level: \
             let robots report less often, or use a faster machine"
        );
        self.told = dropped;
        self.again_ns = now_ns + 1_000_000_000;
    }
}
