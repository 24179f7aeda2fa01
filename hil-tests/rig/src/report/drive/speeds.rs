//! The colours of speeds.

use crate::report::draw::scale;

/// Different colours of the path.
pub(super) const SPEED_COLOURS: usize = 12;

/// Index of the colour of a share of the top speed.
pub(super) fn speed_index(share: f64) -> usize {
    ((share * SPEED_COLOURS as f64) as usize).min(SPEED_COLOURS - 1)
}

/// Colour of one of the path's curves.
pub(super) fn speed_colour(index: usize) -> String {
    scale::speed_colour((index as f64 + 0.5) / SPEED_COLOURS as f64)
}
