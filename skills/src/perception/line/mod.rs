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

pub use fitter::LineFitter;
