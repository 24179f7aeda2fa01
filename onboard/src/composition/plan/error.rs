//! Why two files do not make a robot.

use config::{Origin, Problem, ProblemKind};
use description::keys::{KeyError, KeyErrors, Section};
use description::site::Site;
use skills::tubes::TubeError;

use super::contents::Plan;

/// Why the files, though each is well formed, do not make a robot.
#[derive(Debug, thiserror::Error)]
pub enum PlanError {
    /// Keys of either file.
    #[error(transparent)]
    Keys(#[from] KeyErrors),
    /// The tube set.
    #[error("tubes: {0}")]
    Tubes(TubeError),
    /// The lidar's scans.
    #[error("lidar: {0}")]
    Lidar(String),
}

impl From<KeyError> for PlanError {
    fn from(error: KeyError) -> Self {
        Self::Keys(error.into())
    }
}

impl From<TubeError> for PlanError {
    fn from(error: TubeError) -> Self {
        match error {
            TubeError::Key(error) => error.into(),
            error => Self::Tubes(error),
        }
    }
}

impl PlanError {
    /// What is wrong, each with file, line and key.
    pub(super) fn problems(self, plan: &Plan) -> Vec<Problem> {
        let (found, expected) = (self.to_string(), "motion tubes that the sensor can judge");
        let errors = match self {
            Self::Keys(errors) => errors,
            Self::Tubes(_) => KeyError::new("tubes", found, expected).into(),
            Self::Lidar(_) => KeyError::new("lidar", found, "scans that the line can carry").into(),
        };
        errors.into_iter().map(|error| place(plan, error)).collect()
    }
}

/// No section is in both files: the key says which file it is of.
fn place(plan: &Plan, error: KeyError) -> Problem {
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
