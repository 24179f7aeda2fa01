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
mod feature;
pub mod lane_end;
pub mod line;
mod wall_fit;
pub mod walls;

pub use feature::FeatureSet;
pub use wall_fit::WallFit;

/// Noise of a range as a share of it, where that is more than the least noise.
pub(crate) const RANGE_STD_SHARE: f64 = 0.01;
