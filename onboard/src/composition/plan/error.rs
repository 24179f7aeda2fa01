//! Why two files make no robot.

use config::{Origin, Problem, ProblemKind};
use description::keys::{KeyError, Section};
use description::site::Site;
use skills::tubes::TubeError;

use super::contents::Plan;

/// Why the files, though each is well formed, make no robot.
#[derive(Debug, thiserror::Error)]
pub enum PlanError {
    /// A key of either file.
    #[error(transparent)]
    Key(#[from] KeyError),
    /// The tube set.
    #[error("tubes: {0}")]
    Tubes(TubeError),
    /// The lidar's scans.
    #[error("lidar: {0}")]
    Lidar(String),
}

impl From<TubeError> for PlanError {
    fn from(error: TubeError) -> Self {
        match error {
            TubeError::Key(error) => Self::Key(error),
            error => Self::Tubes(error),
        }
    }
}

impl PlanError {
    /// The error with file, line and key.
    pub(super) fn place(self, plan: &Plan) -> Problem {
        let (found, expected) = (self.to_string(), "motion tubes that the sensor can judge");
        let error = match self {
            Self::Key(error) => error,
            Self::Tubes(_) => KeyError::new("tubes", found, expected),
            Self::Lidar(_) => KeyError::new("lidar", found, "scans that the line can carry"),
        };
        // No section is in both files.
        let section = error.key.split('.').next().unwrap_or_default();
        let origin: &Origin = if Site::KEYS.contains(&section) {
            &plan.site.origin
        } else {
            &plan.robot.origin
        };
        let KeyError {
            key,
            found,
            expected,
        } = error;
        origin.problem(ProblemKind::Inconsistent, &key, found, expected)
    }
}
