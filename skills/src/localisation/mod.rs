//! The pose in `map`: dead reckoning corrected by walls (an extended Kalman filter over x, y, θ).
//!
//! Odometry moves the pose and lets its covariance grow; every wall that perception found pulls it back in the two
//! numbers that a wall tells, distance and heading. A correction that is improbable (chi-square of two degrees of freedom)
//! is refused and counted. The pose is *uncertain* when the covariance passes its limits (with hysteresis), when walls are
//! refused in scan after scan, when scans show none of the walls that should be there, or when beams keep passing
//! through walls; a few good scans in a row end it.
//!
//! [`PoseFilter::see_walls`] does all of this with every mapped wall in view. Whoever corrects by single walls instead
//! ([`PoseFilter::correct`], then [`PoseFilter::scan_done`]) must not do so with a scan that `see_walls` has used: the
//! same points would count twice.
//!
//! Real time: no allocation, no lock, no panic.

mod doubt;
mod filter;
mod walls;

pub use doubt::ScanVerdict;
pub use filter::{PoseCounters, PoseFilter};
pub use walls::WallsOutcome;

#[cfg(test)]
mod tests;
