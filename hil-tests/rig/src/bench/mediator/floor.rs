//! A mediator as a process of its own, and two robots on its floor.

use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use onboard::cli::Failure;
use sim::rt::monotonic_ns;

use super::clocks::Clocks;
use super::robot::{Robot, SITE};
use super::wire::Wire;
use crate::folder::Folder;
use crate::network::endpoint::{free_endpoint, open_session};
use crate::output::write;
use crate::process::janitor::Janitor;
use crate::process::mediator::{MediatorProcess, MediatorSetup};

const SITE_FILE: &str = include_str!("round.toml");
const NET_FILE: &str = include_str!("../../../../../config/nets/overtaking.toml");
/// The robots; the first goes round.
const ROBOTS: [(&str, &str); 2] = [("fast", "7"), ("slow", "1")];
/// Reports are repeated, as robots do.
const REPORT_NS: u64 = 200_000_000;
/// A mediator that has not let anybody overtake by then never will.
const PATIENCE: Duration = Duration::from_secs(40);
/// Longest wait for a message before the robots are looked at.
const LOOK: Duration = Duration::from_millis(1);
/// Last lines of a log that are shown.
const LINES: usize = 10;

/// A running floor; dropping it stops the mediator.
pub(super) struct Floor {
    robots: [Robot; 2],
    /// What was measured.
    pub(super) clocks: Clocks,
    wire: Wire,
    mediator: MediatorProcess,
    // Has site, journal and log.
    _folder: Folder,
    _janitor: Janitor,
}

impl Floor {
    /// Starts the mediator.
    ///
    /// # Errors
    /// [`Failure`] with what is missing.
    pub(super) fn start() -> Result<Self, Failure> {
        let program = std::env::current_exe().map_err(Failure::refused)?;
        let folder = Folder::new()?;
        let janitor = Janitor::start(&program, folder.path()).map_err(Failure::refused)?;
        let site_file = write(&folder.path().join("sites"), "round.toml", SITE_FILE)?;
        write(&folder.path().join("nets"), "overtaking.toml", NET_FILE)?;
        let (session, endpoint) = open_session().map_err(Failure::refused)?;
        let key_prefix = format!("rig-bench-{}", std::process::id());
        let wire = Wire::new(session, &key_prefix, &ROBOTS.map(|(id, _)| id))?;
        let mediator = MediatorProcess::start(MediatorSetup {
            program,
            site_file,
            site: SITE.to_owned(),
            journal: folder.path().join("journal.redb"),
            key_prefix,
            listen: free_endpoint().map_err(Failure::refused)?,
            connect: Some(endpoint),
            keys: None,
            runtime: folder.path().join("mediator"),
            log: folder.path().join("mediator.log"),
        });
        let mediator = mediator.map_err(Failure::refused)?;
        let mut boot_epoch = 10;
        let robots = ROBOTS.map(|(id, at)| {
            boot_epoch += 1;
            Robot::new(id, at, boot_epoch, id == ROBOTS[0].0)
        });
        Ok(Self {
            robots,
            clocks: Clocks::default(),
            wire,
            mediator,
            _folder: folder,
            _janitor: janitor,
        })
    }

    /// Runs until the fast robot has driven two laps, or until it is told to end, and forgets what was measured.
    ///
    /// # Errors
    /// [`Failure`] when that takes too long, with the end of the mediator's log.
    pub(super) fn warm_up(&mut self, asked_to_end: &AtomicBool) -> Result<(), Failure> {
        let began = Instant::now();
        while self.robots[0].laps < 2 && !asked_to_end.load(Ordering::Relaxed) {
            if began.elapsed() > PATIENCE || self.mediator.poll().is_some() {
                return Err(self.stuck());
            }
            self.step()?;
        }
        self.clocks = Clocks::default();
        Ok(())
    }

    /// Runs for so long, and on until something was measured.
    ///
    /// # Errors
    /// As of [`Self::warm_up`].
    pub(super) fn run(
        &mut self,
        length: Duration,
        measured: impl Fn(&Clocks) -> bool,
    ) -> Result<(), Failure> {
        (self.clocks.grants, self.clocks.commands) = (Vec::new(), Vec::new());
        let began = Instant::now();
        while began.elapsed() < length || !measured(&self.clocks) {
            if began.elapsed() > length + PATIENCE || self.mediator.poll().is_some() {
                return Err(self.stuck());
            }
            self.step()?;
        }
        Ok(())
    }

    fn step(&mut self) -> Result<(), Failure> {
        if let Some((at_ns, message)) = self.wire.receive(LOOK) {
            self.clocks.receive(at_ns, &message);
            for (robot, (id, _)) in self.robots.iter_mut().zip(ROBOTS) {
                if message.robot_id == id {
                    robot.hear(&message, at_ns);
                }
            }
        }
        for (robot, (id, _)) in self.robots.iter_mut().zip(ROBOTS) {
            let now_ns = monotonic_ns();
            let news = robot.step(now_ns);
            let due = { robot.reported_ns }.is_none_or(|at_ns| now_ns >= at_ns + REPORT_NS);
            if news || due {
                robot.reported_ns = Some(now_ns);
                let (report, meaning) = (robot.report(), robot.control.as_ref());
                let control = report.control.as_ref();
                self.clocks.send(id, &report.access, control, meaning);
                self.wire.send(&report)?;
            }
        }
        Ok(())
    }

    fn stuck(&self) -> Failure {
        Failure::failed(format_args!(
            "nobody overtakes: {}",
            self.mediator.log_tail(LINES)
        ))
    }
}
