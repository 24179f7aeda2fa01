//! The sheet that drawings of one page share.

/// Width of the page in pixels, and what is left free at its sides.
pub(in crate::report) const WIDTH_PX: f64 = 1600.0;
pub(in crate::report) const MARGIN_PX: f64 = 40.0;
/// Map and charts begin and end here.
pub(in crate::report) const PLOT_LEFT_PX: f64 = 96.0;
pub(in crate::report) const PLOT_RIGHT_PX: f64 = WIDTH_PX - MARGIN_PX;
