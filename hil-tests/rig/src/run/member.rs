//! One robot of a run through the real programs.

use std::process::ExitStatus;

use coordination::symbols::Namespace;
use onboard::cli::Failure;
use onboard::symbols::faults::FaultTable;
use serde_json::Value as Json;

use crate::belief::Insight;
use crate::process::Usage;
use crate::process::robot::{RobotProcess, RobotSetup};
use crate::stand_ins::caretaker::{Blame, Care, Caretaker};
use crate::testbed::Devices;

/// One robot. Fields are dropped in this order: the robot first, then its devices.
pub struct Member {
    pub(super) process: Option<RobotProcess>,
    /// Its devices.
    pub devices: Devices,
    /// Memory and processor time of its last process.
    pub usage: Usage,
    pub(super) setup: RobotSetup,
    pub(super) start_at_ns: u64,
    pub(super) started: bool,
    /// It was killed on purpose.
    pub(super) ends_on_purpose: bool,
    pub(super) insight: Option<Insight>,
    /// The operator who resets it.
    pub(super) caretaker: Caretaker,
    /// Its symbols just before it was stopped.
    pub(super) symbols: Json,
}

impl Member {
    /// Starts its process, unless it runs; one that has ended is started again.
    ///
    /// # Errors
    /// [`Failure::Failed`] with the operating system's reason.
    pub fn start(&mut self) -> Result<(), Failure> {
        if self
            .process
            .as_mut()
            .is_some_and(|own| own.poll().is_none())
        {
            return Ok(());
        }
        // Dropping the old process removes what it left.
        self.process = None;
        let setup = self.setup.clone();
        let process = if self.started {
            RobotProcess::start_again(setup)
        } else {
            RobotProcess::start(setup)
        };
        let process = process.map_err(|error| {
            Failure::failed(format_args!(
                "robot {} cannot be started: {error}",
                self.setup.id
            ))
        })?;
        self.started = true;
        self.ends_on_purpose = false;
        self.insight = None;
        self.usage = Usage::of(process.id());
        self.process = Some(process);
        Ok(())
    }

    /// Kills its process, if it runs.
    pub fn kill(&mut self) {
        self.ends_on_purpose = true;
        if let Some(process) = &mut self.process {
            process.kill();
        }
    }

    /// The number of its process, once it was started.
    #[must_use]
    pub fn process_id(&self) -> Option<u32> {
        self.process.as_ref().map(RobotProcess::id)
    }

    /// What it shows of itself; none before it runs.
    pub(super) fn insight(&mut self, place: &Namespace) -> Option<&mut Insight> {
        if self.insight.is_none() {
            // It runs from when its symbols can be read.
            self.insight = Insight::open(&self.setup.id, place).ok();
        }
        self.insight.as_mut()
    }

    /// What it says of its faults; nothing while it does not run.
    pub(super) fn faults(&mut self, place: &Namespace) -> FaultTable {
        let runs = { self.process.as_mut() }.is_some_and(|own| own.poll().is_none());
        let insight = if runs { self.insight(place) } else { None };
        insight.map(Insight::faults).unwrap_or_default()
    }

    /// What its operator does now.
    pub(super) fn care(&mut self, faults: &FaultTable, now_ns: u64, blame: Blame<'_>) -> Care {
        // Only tests stop a robot through the real programs, and they let it go on.
        self.caretaker.look(faults, now_ns, true, blame)
    }

    /// Its exit status, once it has ended.
    pub(super) fn poll(&mut self) -> Option<ExitStatus> {
        self.process.as_mut()?.poll()
    }

    /// Its identity.
    #[must_use]
    pub fn id(&self) -> &str {
        &self.setup.id
    }
}
