//! What only the robot's and the site's file together can tell.

use crate::diagnostic::{ConfigError, ProblemKind};
use crate::hint;
use crate::loaded::RobotConfig;
use crate::loaded::SiteConfig;

/// Checks that the site knows the robot. Whether the robot can drive there is judged by `skills`.
///
/// # Errors
/// The robot's identity, with the name that may be meant.
pub fn check_together(robot: &RobotConfig, site: &SiteConfig) -> Result<(), ConfigError> {
    let id = robot.identity.id.as_str();
    if site.robots.contains_key(id) {
        return Ok(());
    }
    let known: Vec<&str> = site.robots.keys().map(String::as_str).collect();
    let id = robot.identity.id.as_str();
    let problem = robot.origin.problem(
        ProblemKind::UnknownReference,
        "identity.id",
        format!("robot `{id}`, which {} does not have", site.origin.file()),
        format!("a robot with a section [robots.{id}] in the site file"),
    );
    let problem = match hint::for_name(id, &known) {
        Some(advice) => problem.with_hint(advice),
        None => problem,
    };
    Err(problem.into())
}
