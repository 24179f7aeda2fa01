//! What steering works on: the error from a path, and the curve to drive.

/// Where the robot is relative to the path it should be on.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PathError {
    /// Positive to the left of the path.
    pub lateral_m: f64,
    /// Positive turned to the left of the path's direction.
    pub heading_rad: f64,
}

/// How to steer.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Steer {
    /// Relative to the path.
    pub error: PathError,
    /// Turning per metre driven forward, positive to the left.
    pub curvature_1_m: f64,
    /// +1 forward, −1 backward.
    pub direction: f64,
    /// Of the path there.
    pub path_curvature_1_m: f64,
    /// Of the speed limit, what is sensible with this error.
    pub speed_share: f64,
}
