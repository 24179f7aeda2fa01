//! How a scenario is run through the real programs.

use std::path::PathBuf;

use crate::process::robot::Program;

/// How a scenario is run.
#[derive(Clone, Debug)]
pub struct Options {
    /// The program that becomes mediator and robots: the rig's own.
    pub program: PathBuf,
    /// The program that becomes robots instead: `onboard` itself.
    pub onboard: Option<PathBuf>,
    /// Decides wheel errors, start offsets, starting times, noise, and what stands in the way.
    pub seed: u64,
    /// Folder for what the run leaves.
    pub out: PathBuf,
    /// Show nothing while it runs.
    pub headless: bool,
    /// Start a mediator where the site asks for one.
    pub mediator: bool,
    /// Leave the site's coordinations as they are.
    pub nets: bool,
    /// Certificates on every link.
    pub secure: bool,
}

impl Options {
    /// What becomes a robot.
    #[must_use]
    pub fn robot(&self) -> Program {
        match &self.onboard {
            Some(onboard) => Program::Onboard(onboard.clone()),
            None => Program::Rig(self.program.clone()),
        }
    }
}
