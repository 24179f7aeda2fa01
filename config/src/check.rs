//! Checks of values against each other, after each has been checked alone.

use crate::diagnostic::ConfigError;
use crate::reader::Report;
use crate::robot::RobotConfig;
use crate::site::SiteConfig;

pub(crate) fn robot(_robot: &RobotConfig, _report: &Report) {}
pub(crate) fn site(_site: &SiteConfig, _report: &Report) {}

/// Checks what only the robot's and the site's file together can tell.
///
/// # Errors
/// Everything that does not fit, at once.
pub fn check_together(_robot: &RobotConfig, _site: &SiteConfig) -> Result<(), ConfigError> {
    Ok(())
}
