//! From two files to the plan.

use config::{ConfigError, check_together, load_robot, load_site};
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
        let together = check_together(&robot, &site);
        let start = site.robots.get(&robot.identity.id).cloned();
        let fsm = { start.as_ref() }.and_then(|start| site.fsm.get(&start.role).cloned());
        let (Some(start), Some(fsm)) = (start, fsm) else {
            let unknown = || Failure::refused("the site does not know this robot or its role");
            return Err(together.err().map_or_else(unknown, report));
        };
        let role = start.role.clone();
        let mut plan = Self {
            robot,
            site,
            role,
            fsm,
            start,
            tube_report: TubeReport::default(),
        };
        let errors = plan.build_once().into_iter();
        let mut refused = together.err();
        for problem in errors.flat_map(|error| error.problems(&plan)) {
            let told = |error: &ConfigError| error.problems().iter().any(|p| p.key == problem.key);
            refused = Some(match refused {
                Some(error) if told(&error) => error,
                Some(error) => error.and(problem.into()),
                None => problem.into(),
            });
        }
        refused.map_or(Ok(plan), |error| Err(report(error)))
    }

    /// Builds every part, so that what cannot be built is refused before anything is started.
    fn build_once(&mut self) -> Vec<PlanError> {
        let tubes = self.tube_set();
        let errors = [
            self.navigator().err(),
            self.wheel_controller().err().map(PlanError::from),
            self.dead_reckoning().err().map(PlanError::from),
            tubes.map(|(_, report)| self.tube_report = report).err(),
        ];
        errors.into_iter().flatten().collect()
    }
}
