//! From two files to the plan.

use config::{ConfigError, RobotConfig, SiteConfig, check_together, load_robot, load_site};
use skills::borders::BorderGains;
use skills::schedule::{self, RobotReach};
use skills::tubes::{TubeReport, TubeSet};

use super::budget::Budget;
use super::contents::Plan;
use super::error::PlanError;
use super::managed;
use crate::composition::failure::Failure;
use crate::composition::files::{Files, overrides};
use crate::fleet::LEAVING_M;

/// A robot stops at most so far before where it must.
const STOPS_SHORT_M: f64 = 0.03;

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
        Self::new(robot, site).map_err(report)
    }

    /// Checks what the two files mean together, and builds every part once, so that what cannot be built is refused
    /// before anything is started.
    ///
    /// # Errors
    /// Every problem found.
    pub fn new(robot: RobotConfig, site: SiteConfig) -> Result<Self, ConfigError> {
        check_together(&robot, &site)?;
        let start = site.robots[&robot.identity.id].clone();
        let role = start.role.clone();
        let mut plan = Self {
            // The loader has refused roles without a machine.
            fsm: site.fsm[&role].clone(),
            robot,
            site,
            role,
            start,
            tube_report: TubeReport::default(),
            tubes: None,
        };
        let mut refused: Option<ConfigError> = None;
        let errors = plan.build_once().into_iter();
        for problem in errors.flat_map(|error| error.problems(&plan)) {
            let told = |error: &ConfigError| error.problems().iter().any(|p| p.key == problem.key);
            refused = Some(match refused {
                Some(error) if told(&error) => error,
                Some(error) => error.and(problem.into()),
                None => problem.into(),
            });
        }
        refused.map_or(Ok(plan), Err)
    }

    fn build_once(&mut self) -> Vec<PlanError> {
        let tubes = self.tube_set();
        let curvature_1_m =
            { tubes.as_ref() }.map_or(f64::INFINITY, |(set, _)| set.most_curvature_1_m());
        let errors = [
            self.check_schedules(curvature_1_m).err(),
            self.navigator().err(),
            self.wheel_controller().err().map(PlanError::from),
            self.dead_reckoning().err().map(PlanError::from),
            self.keep_tubes(tubes).err(),
            Budget::check(self).err().map(PlanError::from),
            managed::check(self).err().map(PlanError::from),
        ];
        errors.into_iter().flatten().collect()
    }

    /// They take long to make, and every start of the robot needs them.
    fn keep_tubes(
        &mut self,
        made: Result<(TubeSet, TubeReport), PlanError>,
    ) -> Result<(), PlanError> {
        let (set, report) = made?;
        (self.tubes, self.tube_report) = (Some(set), report);
        Ok(())
    }

    fn check_schedules(&self, tube_curvature_1_m: f64) -> Result<(), PlanError> {
        let (lidar, gains) = (&self.robot.lidar, &self.robot.navigation);
        let border_m = gains.border_sigma * gains.start_std_m
            + gains.map_error_m
            + BorderGains::default().margin_m;
        let reach = RobotReach {
            footprint: self.robot.footprint,
            sees_m: lidar.mount.x_m + lidar.range_max_m,
            tube_curvature_1_m,
            ahead_of_border_m: border_m + STOPS_SHORT_M,
            behind_border_m: border_m + LEAVING_M,
        };
        Ok(schedule::check(
            &self.site,
            &self.robot.identity.id,
            &reach,
        )?)
    }
}
