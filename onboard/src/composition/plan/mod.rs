//! The plan: a robot file and a site file, checked, and made into the parts that the activities run.

mod differences;
mod fleet;
mod parts;
mod refusal;

use std::time::Duration;

use config::{RobotConfig, SiteConfig, check_together, load_robot, load_site};
use coordination::fsm::{ModelError, StateId};
use description::site::{FsmConfig, SiteRobot};
use description::threads::{Core, Scheduling, ThreadConfig};
use skills::drive::DriveLimitError;
use skills::navigator::SetupError;
use skills::odometry::GeometryError;
use skills::tubes::{TubeError, TubeReport};

use crate::activities::navigation;
use crate::composition::failure::Failure;
use crate::composition::files::{Files, overrides};
use crate::realtime::scheduling::{CoreClass, Wanted};

/// What the two files say, checked as far as that can be done without a device.
#[derive(Clone, Debug)]
pub struct Plan {
    /// The robot file.
    pub robot: RobotConfig,
    /// The site file.
    pub site: SiteConfig,
    /// Role that the site gives this robot.
    pub role: String,
    /// The state machine of that role.
    pub fsm: FsmConfig,
    /// Where it starts, and in which state.
    pub start: SiteRobot,
    /// What the tube set came to.
    pub tube_report: TubeReport,
}

/// Why the files, though each is well formed, make no robot.
#[derive(Debug, thiserror::Error)]
pub enum PlanError {
    /// The state machine.
    #[error("state machine: {0}")]
    Machine(#[from] ModelError),
    /// The events of monitors.
    #[error("monitors: {0}")]
    Events(String),
    /// Map, skills, gains.
    #[error("navigation: {0}")]
    Navigation(#[from] SetupError),
    /// The tube set.
    #[error("tubes: {0}")]
    Tubes(#[from] TubeError),
    /// The drive's geometry.
    #[error("drive: {0}")]
    Geometry(#[from] GeometryError),
    /// The drive's limits.
    #[error("drive: {0}")]
    Limits(#[from] DriveLimitError),
    /// The lidar's scans.
    #[error("lidar: {0}")]
    Lidar(String),
}

impl Plan {
    /// Loads and checks both files, and builds every part once.
    ///
    /// # Errors
    /// [`Failure::Refused`] with every problem found.
    pub fn load(files: &Files) -> Result<Self, Failure> {
        let overrides = overrides(&files.set)?;
        let report = |error| Failure::Refused(miette::Report::new(error));
        let robot = load_robot(&files.robot, &overrides).map_err(report)?;
        let site = load_site(&files.site, &overrides).map_err(report)?;
        check_together(&robot, &site).map_err(report)?;
        let id = &robot.identity.id;
        let start = site.robots.get(id).cloned().ok_or_else(|| {
            Failure::refused(format_args!(
                "site `{}` does not say where robot `{id}` starts",
                site.name
            ))
        })?;
        let fsm = site.fsm.get(&start.role).cloned().ok_or_else(|| {
            Failure::refused(format_args!(
                "site `{}` has no state machine for role `{}`",
                site.name, start.role
            ))
        })?;
        let role = start.role.clone();
        let mut plan = Self {
            robot,
            site,
            role,
            fsm,
            start,
            tube_report: TubeReport::default(),
        };
        if let Err(error) = plan.build_once() {
            return Err(refusal::of(&plan, &error));
        }
        Ok(plan)
    }

    /// Builds every part, so that what cannot be built is refused before anything is started.
    fn build_once(&mut self) -> Result<(), PlanError> {
        self.navigator()?;
        self.wheel_controller()?;
        self.dead_reckoning()?;
        let (_, report) = self.tube_set()?;
        self.tube_report = report;
        Ok(())
    }

    /// Where the robot starts, in `state` of its machine.
    #[must_use]
    pub fn start(&self, state: StateId) -> navigation::Start {
        let gains = &self.robot.navigation;
        navigation::Start {
            pose: self.start.start,
            std_m: gains.start_std_m,
            std_rad: gains.start_std_rad,
            state,
        }
    }
}

/// Milliseconds as nanoseconds.
#[must_use]
pub fn ns_from_ms(milliseconds: u32) -> u64 {
    u64::try_from(Duration::from_millis(u64::from(milliseconds)).as_nanos()).unwrap_or(u64::MAX)
}

/// Names of the configured threads, in their order.
#[must_use]
pub fn thread_names(robot: &RobotConfig) -> Vec<String> {
    robot
        .threads
        .iter()
        .map(|thread| thread.name.clone())
        .collect()
}

/// What a thread asks the scheduler for.
#[must_use]
pub fn wanted_scheduling(thread: &ThreadConfig) -> Wanted {
    Wanted {
        fifo_priority: match thread.scheduling {
            Scheduling::Fifo { priority } => Some(u8::try_from(priority).unwrap_or(u8::MAX)),
            Scheduling::Normal => None,
        },
        cores: match thread.core {
            Core::Any => CoreClass::Any,
            Core::Big => CoreClass::Big,
            Core::Little => CoreClass::Little,
            Core::Number(number) => CoreClass::Number(number),
        },
    }
}

#[cfg(test)]
mod tests;
