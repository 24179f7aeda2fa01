//! One robot of a run through the real programs.

use std::process::ExitStatus;

use onboard::cli::Failure;
use serde_json::Value as Json;

use crate::belief::Insight;
use crate::process::Usage;
use crate::process::robot::{RobotProcess, RobotSetup};
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
