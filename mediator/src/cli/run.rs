//! `mediator run`.

use std::path::PathBuf;
use std::sync::Arc;

use clap::Args;
use contract::draw::draw;
use contract::logging::{LevelFilter, Logging, Targets};
use signal_hook::consts::{SIGINT, SIGTERM};
use signal_hook::iterator::Signals;

use super::failure::Failure;
use super::files::{load_site, plans};
use super::network;
use crate::journal::Store;
use crate::manager::Manager;
use crate::runtime::{Folder, Runtime};
use crate::setup::Setup;

#[derive(Debug, Args)]
pub(super) struct Arguments {
    /// Site file, the same as the robots'
    #[arg(long, value_name = "FILE")]
    site: PathBuf,
    /// Where grants are recorded [default: $XDG_STATE_HOME/mediator/SITE.redb]
    #[arg(long, value_name = "FILE")]
    journal: Option<PathBuf>,
    /// Begin a journal if there is none: this site had no mediator before, or its journal is lost
    #[arg(long)]
    first_start: bool,
    #[command(flatten)]
    network: network::Arguments,
    /// Folder for the sockets of running mediators [default: $XDG_RUNTIME_DIR/mediator, or /tmp/mediator-UID]
    #[arg(long, value_name = "DIR", env = "MEDIATOR_RUNTIME_DIR")]
    runtime: Option<PathBuf>,
}

pub(super) fn run(arguments: Arguments) -> Result<(), Failure> {
    let _logging = Logging::start("MEDIATOR_LOG", &logged(), || true);
    let site = load_site(&arguments.site)?;
    let setup = Setup::of(&site).map_err(|error| Failure::Refused(error.to_string()))?;
    let settings = arguments.network.settings(&site.name)?;
    let folder = Folder::new(arguments.runtime, &site.name).map_err(Failure::Refused)?;
    let journal = arguments
        .journal
        .unwrap_or_else(|| Folder::default_journal(&site.name));
    if let Some(parent) = journal.parent() {
        std::fs::create_dir_all(parent).map_err(|error| {
            Failure::Refused(format!(
                "folder {} cannot be made: {error}",
                parent.display()
            ))
        })?;
    }
    let (store, stored) =
        Store::open(&journal, &site.name).map_err(|error| Failure::Refused(error.to_string()))?;
    if stored.epoch == 0 && !arguments.first_start {
        return Err(Failure::Refused(format!(
            "journal {} is empty. If this site had a mediator before, its journal is elsewhere: name it with --journal. If it had \
             none, or its journal is lost, add --first-start",
            journal.display()
        )));
    }
    if stored.epoch > 0 && arguments.first_start {
        tracing::warn!(
            "journal {} has been in use before: leave out --first-start from now on, so that one that is lost is refused",
            journal.display()
        );
    }
    let plans = plans(&arguments.site, &site, &setup)?;
    for plan in &plans {
        for warning in plan.warnings() {
            tracing::warn!("coordination {}, net {}: {warning}", plan.id, plan.net);
        }
    }
    let manager = Manager::with_plans(&setup, plans, &stored, 0)
        .map_err(|error| Failure::Refused(error.to_string()))?
        .speaks_as(draw());
    tracing::info!(
        "site {}, {} areas, {} robots; journal {}, start {}",
        site.name,
        setup.areas.len(),
        setup.robots.len(),
        journal.display(),
        manager.epoch()
    );
    let awaited = manager.status(0).awaited;
    if !awaited.is_empty() {
        tracing::info!(
            "nothing is granted until these robots have reported where they stand, or are said to be absent (`mediator absent ROBOT`): {}",
            awaited.join(", ")
        );
    }
    let mut signals = Signals::new([SIGINT, SIGTERM])
        .map_err(|error| Failure::Failed(format!("signals cannot be caught: {error}")))?;
    let journal = (store, stored.orders);
    let runtime = Runtime::start(manager, journal, settings, &folder).map_err(Failure::Refused)?;
    let shared = runtime.shared();
    let handle = signals.handle();
    let waiting = {
        let shared = Arc::clone(&shared);
        std::thread::spawn(move || {
            if signals.forever().next().is_some() {
                shared.stop();
            }
        })
    };
    let outcome = runtime.join();
    handle.close();
    // It only waits for signals, and there are none any more.
    let _ = waiting.join();
    outcome.map_err(Failure::Failed)
}

/// What is logged unless `MEDIATOR_LOG` says otherwise.
fn logged() -> Targets {
    Targets::new()
        .with_default(LevelFilter::INFO)
        .with_target("zenoh", LevelFilter::ERROR)
}
