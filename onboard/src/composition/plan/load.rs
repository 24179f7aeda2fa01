//! From two files to the plan.

use config::{check_together, load_robot, load_site};
use skills::tubes::TubeReport;

use super::contents::Plan;
use super::error::PlanError;
use crate::composition::failure::Failure;
use crate::composition::files::{Files, overrides};

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
            return Err(Failure::Refused(miette::Report::new(error.place(&plan))));
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
}
