//! What the trackers are tuned by.

/// Noise of a range as a share of it, where that is more than the least noise.
pub const RANGE_STD_SHARE: f64 = 0.01;

/// How scans are judged.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PerceptionGains {
    /// A point this near to a line belongs to it.
    pub inlier_m: f64,
    /// Points that a wall needs.
    pub min_points: usize,
    /// Noise of one range, at least.
    pub range_std_m: f64,
    /// Measurements farther than this many standard deviations are refused.
    pub gate_sigma: f64,
    /// Growth of a tracked position's standard deviation over one metre driven (it grows with the root of the way).
    pub odometry_std_m_per_m: f64,
    /// The same of a tracked heading.
    pub odometry_std_rad_per_m: f64,
}

impl Default for PerceptionGains {
    fn default() -> Self {
        Self {
            inlier_m: 0.05,
            min_points: 12,
            range_std_m: 0.01,
            gate_sigma: 4.0,
            odometry_std_m_per_m: 0.03,
            odometry_std_rad_per_m: 0.03,
        }
    }
}
