//! Figures beyond which something is a violation.

/// Least clearance of a scenario that does not say.
pub const CLEARANCE_M: f64 = 0.10;

/// What is a violation. A figure without a limit is measured all the same where it can be.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Limits {
    /// Least distance of footprints to anything else; 0: only contact is a violation.
    pub clearance_m: f64,
    /// A robot that stands may be run into.
    pub may_be_run_into: bool,
    /// Largest distance of `base_link` from the lane's centre in areas that are driven forward on a lane.
    pub lateral_error_m: Option<f64>,
    /// By which share the speed may exceed an area's limit.
    pub over_speed: Option<f64>,
    /// Largest error of the believed pose across a wall in view.
    pub pose_error_m: Option<f64>,
    /// Largest error of the believed heading while a wall is in view, in degrees.
    pub heading_error_deg: Option<f64>,
    /// Largest error of stops at walls.
    pub dock_error_m: Option<f64>,
    /// Largest believed error of stops at poses: along a corridor nothing tells a robot where it is.
    pub pose_stop_error_m: Option<f64>,
    /// Largest error of stops before areas, farther from or nearer to the border than wanted.
    pub border_stop_error_m: Option<f64>,
}

impl Default for Limits {
    fn default() -> Self {
        Self {
            clearance_m: CLEARANCE_M,
            may_be_run_into: false,
            lateral_error_m: None,
            over_speed: None,
            pose_error_m: None,
            heading_error_deg: None,
            dock_error_m: None,
            pose_stop_error_m: None,
            border_stop_error_m: None,
        }
    }
}

impl Limits {
    /// Whether a limit concerns what a robot believes, or the states of its machine.
    #[must_use]
    pub fn concern_belief(&self) -> bool {
        let limits = [
            self.pose_error_m,
            self.heading_error_deg,
            self.dock_error_m,
            self.pose_stop_error_m,
            self.border_stop_error_m,
        ];
        limits.iter().any(Option::is_some)
    }
}
