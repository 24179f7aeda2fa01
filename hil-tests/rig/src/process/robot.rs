//! A robot as a process of its own.

use description::instruction::Instruction;
use std::ffi::OsString;
use std::fs;
use std::io;
use std::path::PathBuf;
use std::process::ExitStatus;

use coordination::symbols::remove_stale;
use onboard::cli::Failure;
use onboard::process::ctl::{self, Event, Request};
use onboard::process::runtime::Runtime;
use rustix::process::Signal;

use super::child::Process;

/// Hidden subcommand by which this program becomes a robot.
pub const SUBCOMMAND: &str = "__robot";

/// A program that becomes a robot.
#[derive(Clone, Debug)]
pub enum Program {
    /// The rig's own.
    Rig(PathBuf),
    /// `onboard` itself.
    Onboard(PathBuf),
}

/// What a robot is started with.
#[derive(Clone, Debug)]
pub struct RobotSetup {
    /// The program that becomes the robot.
    pub program: Program,
    /// Its identity, as its file says.
    pub id: String,
    /// Robot file.
    pub robot_file: PathBuf,
    /// Site file.
    pub site_file: PathBuf,
    /// `--set` arguments.
    pub set: Vec<String>,
    /// Folder for its control socket.
    pub runtime: PathBuf,
    /// Where its log goes.
    pub log: PathBuf,
    /// Environment on top of ours.
    pub environment: Vec<(String, String)>,
}

/// A running robot. Dropping it stops it and removes what it may have left.
#[derive(Debug)]
pub struct RobotProcess {
    process: Process,
    setup: RobotSetup,
}

impl RobotProcess {
    /// Starts it with an empty log.
    ///
    /// # Errors
    /// The operating system's.
    pub fn start(setup: RobotSetup) -> io::Result<Self> {
        fs::File::create(&setup.log)?;
        Self::start_again(setup)
    }

    /// Starts it again; its log is continued.
    ///
    /// # Errors
    /// The operating system's.
    pub fn start_again(setup: RobotSetup) -> io::Result<Self> {
        let (program, becomes) = match &setup.program {
            Program::Rig(path) => (path, Some(SUBCOMMAND)),
            Program::Onboard(path) => (path, None),
        };
        let words = becomes.into_iter().chain(["run", "--robot"]);
        let mut arguments: Vec<OsString> = words.map(Into::into).collect();
        arguments.push(setup.robot_file.clone().into());
        arguments.extend(["--site".into(), setup.site_file.clone().into()]);
        arguments.extend(["--runtime".into(), setup.runtime.clone().into()]);
        for value in &setup.set {
            arguments.extend(["--set".into(), value.into()]);
        }
        let process = Process::start(program, &arguments, &setup.environment, &setup.log)?;
        Ok(Self { process, setup })
    }

    /// Its process id.
    #[must_use]
    pub fn id(&self) -> u32 {
        self.process.id()
    }

    /// How it was started.
    #[must_use]
    pub fn setup(&self) -> &RobotSetup {
        &self.setup
    }

    /// Its exit status, once it has ended.
    pub fn poll(&mut self) -> Option<ExitStatus> {
        self.process.poll()
    }

    /// Sends it a signal, unless it has ended.
    pub fn signal(&mut self, signal: Signal) {
        self.process.signal(signal);
    }

    /// Asks it to stop, and waits until it has.
    pub fn stop(&mut self) -> ExitStatus {
        self.process.stop()
    }

    /// Kills it.
    pub fn kill(&mut self) -> ExitStatus {
        self.process.kill()
    }

    /// Removes what a robot that was killed may have left: shared memory and its control socket.
    fn clean_up(&self) {
        if let Ok(runtime) = Runtime::new(Some(self.setup.runtime.clone())) {
            // A robot that ended by itself has left nothing.
            let _ = remove_stale(&self.setup.id, &runtime.place());
            let _ = fs::remove_file(runtime.socket(&self.setup.id));
        }
    }

    /// The last lines of its log.
    #[must_use]
    pub fn log_tail(&self, lines: usize) -> String {
        self.process.log_tail(lines)
    }
}

impl Drop for RobotProcess {
    fn drop(&mut self) {
        self.stop();
        self.clean_up();
    }
}

/// Sends a robot that runs as a process an instruction, as an operator does.
///
/// # Errors
/// A sentence with the robot's reason.
pub fn send(
    runtime: &Runtime,
    robot: &str,
    instruction: &Instruction<String>,
) -> Result<(), String> {
    let request = Request::Send(Event(instruction.clone()));
    ctl::send(runtime, Some(robot), &request).map_err(|failure| match failure {
        Failure::Refused(report) | Failure::Failed(report) => report.to_string(),
    })
}
