//! Why two files make no robot.

use coordination::fsm::ModelError;
use skills::drive::DriveLimitError;
use skills::navigator::SetupError;
use skills::odometry::GeometryError;
use skills::tubes::TubeError;

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
