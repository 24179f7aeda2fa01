//! One robot that drives, with its devices and its world.

use std::fs;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use coordination::symbols::Inspector;
use onboard::cli::Failure;
use onboard::process::runtime::Runtime;
use sim::rt::monotonic_ns;

use super::eyes::Eyes;
use crate::folder::Folder;
use crate::process::log_tail;
use crate::run::Options;
use crate::run::stage::Stage;
use crate::scenario::Scenario;

/// A robot that has not driven by then never will.
const PATIENCE: Duration = Duration::from_secs(30);
/// How often is looked whether it does: a bus cycle.
const LOOK: Duration = Duration::from_millis(1);
/// Last lines of a log that are shown.
const LINES: usize = 10;

/// `onboard` beside this program, if it is there: the rig as a robot has all of the rig in its memory.
pub(super) fn onboard_beside(program: &Path) -> Option<PathBuf> {
    let onboard = program.with_file_name("onboard");
    onboard.is_file().then_some(onboard)
}

/// What is to be known of the program that becomes the robot.
pub(super) fn note(program: &Path) -> String {
    let Some(onboard) = onboard_beside(program) else {
        return "the robot is this program, which is larger than `onboard`: that was not built beside it, as by \
                `cargo build --release --bin onboard`"
            .to_owned();
    };
    let built = |path: &Path| fs::metadata(path).ok()?.modified().ok();
    let before = built(program).zip(built(&onboard));
    let before = before.and_then(|(own, onboard)| own.duration_since(onboard).ok());
    let before_min = before.unwrap_or_default().as_secs() / 60;
    format!(
        "the robot is {}, built {before_min} min before this program",
        onboard.display()
    )
}

/// A robot; dropping it stops it.
pub(super) struct Running {
    id: u32,
    /// When its process was started, and when the drive had the first setpoint with its motors on, on the monotonic clock.
    pub(super) started_ns: (u64, u64),
    stage: Stage,
    // Has the log.
    _folder: Folder,
}

impl Running {
    /// Starts the scenario's first robot, and waits until its drive has a setpoint with both motors on.
    ///
    /// # Errors
    /// [`Failure`] when it does not get there, with the end of its log.
    pub(super) fn start(scenario: &Scenario) -> Result<Self, Failure> {
        let folder = Folder::new()?;
        let program = std::env::current_exe().map_err(Failure::refused)?;
        let options = Options {
            onboard: onboard_beside(&program),
            program,
            seed: 1,
            out: folder.path().to_owned(),
            headless: true,
            mediator: false,
            nets: true,
            secure: false,
        };
        let mut stage = Stage::set(scenario, &options)?;
        let member = stage.members.first_mut();
        let member = member.ok_or_else(|| Failure::refused("the scenario has no robot"))?;
        let log = folder.path().join(format!("{}.log", member.id()));
        let (began, began_ns) = (Instant::now(), monotonic_ns());
        member.start()?;
        while member.devices.drive.statistics().enabled == 0 {
            if began.elapsed() > PATIENCE {
                return Err(Failure::failed(format_args!(
                    "the robot does not drive within {} s: {}",
                    PATIENCE.as_secs(),
                    log_tail(&log, LINES)
                )));
            }
            std::thread::sleep(LOOK);
        }
        let id = member.process_id();
        Ok(Self {
            id: id.ok_or_else(|| Failure::failed("the robot has ended"))?,
            started_ns: (began_ns, monotonic_ns()),
            stage,
            _folder: folder,
        })
    }

    /// Its process.
    pub(super) fn id(&self) -> u32 {
        self.id
    }

    /// What a watcher needs to see scans become setpoints.
    ///
    /// # Errors
    /// [`Failure`] when its symbols cannot be read.
    pub(super) fn eyes(&self) -> Result<Eyes, Failure> {
        let member = self.stage.members.first();
        let member = member.ok_or_else(|| Failure::failed("there is no robot"))?;
        let runtime = Runtime::new(Some(self.stage.folder().join("run")))?;
        let symbols = Inspector::open(member.id(), &runtime.place()).map_err(Failure::failed)?;
        Ok(Eyes {
            scan: symbols.reader("hokuyo").map_err(Failure::failed)?,
            tubes: symbols.reader("adaptive").map_err(Failure::failed)?,
            setpoints: symbols.reader("kelo").map_err(Failure::failed)?,
            lidar: member.devices.lidar_faults.clone(),
            drive: member.devices.drive.clone(),
        })
    }
}
