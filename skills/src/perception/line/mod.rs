//! Robust straight-line fit to the scan points near a wall that is expected somewhere.
//!
//! The expected wall is a segment in `base_link`. Points inside its gate are taken into the segment's own coordinates
//! (along, across), so that the line is a small correction of the expectation. The fit starts from the pair of points
//! that accounts for most of the wall's length (not for most points: what stands near is dense) and beyond which least is
//! seen, since nothing is seen through a wall; it is refined by weighted least squares with Tukey's weights. What stands
//! in front of the wall does not pull it. A point weighs by its noise across the wall: that of the range, times the sine
//! of the angle under which it is seen. Deterministic; no allocation after construction.

mod fitter;
mod judge;
mod points;

use description::geometry::Point2;

pub use fitter::LineFitter;

/// What a scan has met, and who saw it.
#[derive(Clone, Copy, Debug)]
pub struct ScanPoints<'a> {
    /// In `base_link`.
    pub points: &'a [Point2],
    /// The sensor, in `base_link`.
    pub eye: Point2,
    /// As far as it sees: of what is farther only those points are there that noise has made shorter.
    pub sight_m: f64,
}

impl<'a> ScanPoints<'a> {
    /// Those of a sensor in the middle of the robot that sees everything.
    #[cfg(test)]
    pub(crate) fn all(points: &'a [Point2]) -> Self {
        Self {
            points,
            eye: Point2::default(),
            sight_m: f64::INFINITY,
        }
    }
}
