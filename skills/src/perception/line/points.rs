//! Points of a scan and lines, in the coordinates of an expected wall: along it, across it.

use crate::direction::floor;

/// Walls are not flat to better than this.
pub(super) const FLATNESS_M: f64 = 0.015;
/// Coverage is counted in pieces of this length.
pub(super) const PIECE_M: f64 = 0.1;
pub(super) const PIECES: usize = 128;
/// A point within this many standard deviations lies on the line, even beyond the least distance.
pub(super) const INLIER_SIGMA: f64 = 2.5;

/// A point in the coordinates of the expected wall.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct WallPoint {
    pub(super) along_m: f64,
    pub(super) across_m: f64,
    /// One over the variance of the noise across the wall.
    pub(super) weight_1_m2: f64,
    /// This near to the line it lies on it.
    pub(super) reach_m: f64,
    /// One over that: it is asked for by every line that is tried.
    pub(super) per_reach_1_m: f64,
    /// One over how far from the line noise alone takes it.
    pub(super) per_noise_1_m: f64,
    /// The piece of wall that it lies on.
    pub(super) piece: usize,
    /// One over the number of points on the same piece, so that near, dense pieces weigh as much as far ones.
    pub(super) share: f64,
}

/// Four points, side by side for the processor.
#[derive(Clone, Copy, Debug)]
pub(super) struct Four {
    pub(super) along_m: [f64; 4],
    pub(super) across_m: [f64; 4],
    pub(super) per_reach_1_m: [f64; 4],
    pub(super) share: [f64; 4],
    /// The shares of all points behind these.
    pub(super) left: f64,
}

impl Four {
    pub(super) fn of(points: &[WallPoint; 4]) -> Self {
        Self {
            along_m: points.map(|point| point.along_m),
            across_m: points.map(|point| point.across_m),
            per_reach_1_m: points.map(|point| point.per_reach_1_m),
            share: points.map(|point| point.share),
            left: 0.0,
        }
    }
}

/// A line: across = offset + slope · (along − centre).
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Line {
    pub(super) centre_m: f64,
    pub(super) offset_m: f64,
    pub(super) slope: f64,
}

impl Line {
    pub(super) fn residual_m(&self, along_m: f64, across_m: f64) -> f64 {
        across_m - self.offset_m - self.slope * (along_m - self.centre_m)
    }
}

/// The piece of wall that a point lies on; a very long wall counts round.
pub(super) fn piece(along_m: f64) -> usize {
    floor(along_m / PIECE_M).rem_euclid(PIECES as i64) as usize
}
