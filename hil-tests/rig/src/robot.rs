//! A robot as a process of its own.

use std::ffi::OsString;
use std::fs;
use std::io;
use std::os::unix::process::{CommandExt, ExitStatusExt};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, ExitStatus, Stdio};
use std::time::{Duration, Instant};

use coordination::symbols::remove_stale;
use onboard::runtime::Runtime;
use rustix::process::{Pid, Signal, kill_process};

/// Hidden subcommand by which this program becomes a robot.
pub const SUBCOMMAND: &str = "__robot";

/// How long a robot may take to end when it is asked to.
const PATIENCE: Duration = Duration::from_secs(8);

/// What a robot is started with.
#[derive(Clone, Debug)]
pub struct RobotSetup {
    /// The program that becomes the robot: the rig's own.
    pub program: PathBuf,
    /// Its identity, as its file says.
    pub id: String,
    /// Robot file.
    pub robot_file: PathBuf,
    /// Site file.
    pub site_file: PathBuf,
    /// `--set` arguments.
    pub set: Vec<String>,
    /// Folder for its names.
    pub runtime: PathBuf,
    /// Where its log goes.
    pub log: PathBuf,
    /// Environment on top of ours.
    pub environment: Vec<(String, String)>,
}

/// A running robot. Dropping it stops it and removes what it may have left.
#[derive(Debug)]
pub struct RobotProcess {
    child: Child,
    setup: RobotSetup,
    ended: Option<ExitStatus>,
}

impl RobotProcess {
    /// Starts it, in a process group of its own so that Ctrl-C reaches it by us and not past us.
    ///
    /// # Errors
    /// The operating system's.
    pub fn start(setup: RobotSetup) -> io::Result<Self> {
        let log = fs::File::create(&setup.log)?;
        let mut arguments: Vec<OsString> = vec![SUBCOMMAND.into(), "run".into(), "--robot".into()];
        arguments.push(setup.robot_file.clone().into());
        arguments.extend(["--site".into(), setup.site_file.clone().into()]);
        arguments.extend(["--runtime".into(), setup.runtime.clone().into()]);
        for value in &setup.set {
            arguments.extend(["--set".into(), value.into()]);
        }
        let mut command = Command::new(&setup.program);
        command
            .args(arguments)
            .envs(setup.environment.iter().cloned())
            .stdin(Stdio::null())
            .stdout(Stdio::from(log.try_clone()?))
            .stderr(Stdio::from(log))
            .process_group(0);
        // SAFETY: between fork and exec only one async-signal-safe system call is made: a rig that dies takes its
        // robots with it.
        unsafe {
            command.pre_exec(|| {
                rustix::process::set_parent_process_death_signal(Some(Signal::TERM))
                    .map_err(io::Error::from)
            });
        }
        Ok(Self {
            child: command.spawn()?,
            setup,
            ended: None,
        })
    }

    /// Its process id.
    #[must_use]
    pub fn id(&self) -> u32 {
        self.child.id()
    }

    /// How it was started.
    #[must_use]
    pub fn setup(&self) -> &RobotSetup {
        &self.setup
    }

    /// Its exit status, once it has ended.
    pub fn poll(&mut self) -> Option<ExitStatus> {
        if self.ended.is_none() {
            self.ended = self.child.try_wait().ok().flatten();
        }
        self.ended
    }

    /// Sends it a signal; one that has ended takes none.
    pub fn signal(&mut self, signal: Signal) {
        if self.poll().is_none()
            && let Some(pid) = i32::try_from(self.child.id()).ok().and_then(Pid::from_raw)
        {
            // It may end between the two.
            let _ = kill_process(pid, signal);
        }
    }

    /// Asks it to stop, and waits until it has.
    pub fn stop(&mut self) -> ExitStatus {
        self.signal(Signal::TERM);
        let asked = Instant::now();
        loop {
            if let Some(status) = self.poll() {
                return status;
            }
            if asked.elapsed() > PATIENCE {
                self.signal(Signal::KILL);
                return self
                    .child
                    .wait()
                    .unwrap_or_else(|_| ExitStatus::from_raw(9));
            }
            std::thread::sleep(Duration::from_millis(10));
        }
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
        log_tail(&self.setup.log, lines)
    }
}

impl Drop for RobotProcess {
    fn drop(&mut self) {
        self.stop();
        self.clean_up();
    }
}

fn log_tail(path: &Path, lines: usize) -> String {
    let text = fs::read_to_string(path).unwrap_or_default();
    let all: Vec<&str> = text.lines().collect();
    all[all.len().saturating_sub(lines)..].join("\n")
}
