//! What navigation sees in a scan: the walls beside a lane and the wall at its end.
//!
//! * [`mod@line`]: a robust line fit near an expected wall;
//! * [`corridor`]: orientation and lateral offset in the corridor, tracked between scans with odometry;
//! * [`lane_end`]: distance to the wall that closes the lane, with a count of consistent scans;
//! * [`walls`]: all walls of the map that are in view, for the pose.
//!
//! The trackers look only where the semantic map expects a wall, and each keeps an estimate of its own, so that a wrong
//! pose in `map` does not spoil the feature. All points are in `base_link`. Nothing allocates after construction.

pub mod corridor;
pub mod lane_end;
pub mod line;
pub mod walls;

use nalgebra::Matrix2;

/// Noise of a range as a share of it, where that is more than the least noise.
pub const RANGE_STD_SHARE: f64 = 0.01;

/// A kind of feature.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Feature {
    /// The walls on both sides of the lane.
    Corridor,
    /// The wall that closes the lane ahead.
    LaneEnd,
    /// Every wall of the map that is in view; they correct the pose and nothing else.
    Walls,
}

/// A set of features.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct FeatureSet {
    /// Has [`Feature::Corridor`].
    pub corridor: bool,
    /// Has [`Feature::LaneEnd`].
    pub lane_end: bool,
    /// Has [`Feature::Walls`].
    pub walls: bool,
}

impl FeatureSet {
    /// What either set has.
    #[must_use]
    pub fn union(self, other: Self) -> Self {
        Self {
            corridor: self.corridor || other.corridor,
            lane_end: self.lane_end || other.lane_end,
            walls: self.walls || other.walls,
        }
    }
}

impl FromIterator<Feature> for FeatureSet {
    fn from_iter<I: IntoIterator<Item = Feature>>(features: I) -> Self {
        let mut set = Self::default();
        for feature in features {
            match feature {
                Feature::Corridor => set.corridor = true,
                Feature::LaneEnd => set.lane_end = true,
                Feature::Walls => set.walls = true,
            }
        }
        set
    }
}

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
