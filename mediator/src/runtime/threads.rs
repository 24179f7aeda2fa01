//! Starts both threads, and waits for their end.

use std::collections::BTreeMap;
use std::sync::Arc;

use super::communication;
use super::folder::Folder;
use super::inbox::Inbox;
use super::management::Management;
use super::network::Settings;
use super::shared::Shared;
use super::turning;
use super::waiting::Waiting;
use crate::journal::{OrderRecord, Store};
use crate::manager::Manager;

/// Messages that may wait for communication.
pub const OUTPUTS: usize = 4096;

/// A mediator that runs until it is stopped.
pub struct Runtime {
    shared: Arc<Shared>,
    management: std::thread::JoinHandle<Result<(), String>>,
    communication: std::thread::JoinHandle<Result<(), String>>,
}

impl Runtime {
    /// Opens the network, then starts both threads. `orders` is what the journal has of them.
    ///
    /// # Errors
    /// Why the network or the control socket cannot be opened.
    pub fn start(
        manager: Manager,
        (store, orders): (Store, BTreeMap<u64, OrderRecord>),
        settings: Settings,
        folder: &Folder,
    ) -> Result<Self, String> {
        let shared = Arc::new(Shared::new());
        let inbox = Arc::new(Inbox::new(Waiting::new(manager.robot_ids())));
        let (outbox, outputs) = tokio::sync::mpsc::channel(OUTPUTS);
        let opened = communication::open(settings, folder, &inbox, &shared, manager.instance())?;
        let spawn = |name: &str| std::thread::Builder::new().name(name.to_owned());
        let management = {
            let (shared, inbox) = (Arc::clone(&shared), Arc::clone(&inbox));
            spawn("management").spawn(move || {
                let management = Management::start(manager, store, orders);
                turning::run(management, &inbox, &outbox, &shared)
            })
        };
        let communication = {
            let shared = Arc::clone(&shared);
            spawn("communication")
                .spawn(move || communication::run(opened, inbox, outputs, &shared))
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
