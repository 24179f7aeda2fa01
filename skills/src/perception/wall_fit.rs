//! One wall as a scan shows it.

use nalgebra::Matrix2;

/// A wall found in a scan, as the robot stands to it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WallFit {
    /// Of `base_link` from the wall's line, positive to the left of the wall's direction.
    pub lateral_m: f64,
    /// Heading of `base_link` relative to the wall's direction.
    pub heading_rad: f64,
    /// Of (lateral, heading).
    pub covariance: Matrix2<f64>,
    /// Points on the line.
    pub inliers: u32,
    /// Share of the length with points in the gate whose points lie on the line.
    pub share: f64,
    /// Length of wall that was seen, gaps not counted.
    pub covered_m: f64,
    /// Of the points from the line.
    pub rms_m: f64,
}

impl WallFit {
    /// Standard deviation of the lateral distance.
    #[must_use]
    pub fn lateral_std_m(&self) -> f64 {
        self.covariance[(0, 0)].max(0.0).sqrt()
    }

    /// Standard deviation of the heading.
    #[must_use]
    pub fn heading_std_rad(&self) -> f64 {
        self.covariance[(1, 1)].max(0.0).sqrt()
    }
}
