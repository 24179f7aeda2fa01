//! What several parts of a site measure.

use crate::keys::Quantity;

pub(crate) const SPEED: Quantity = Quantity::new("a speed", "m/s").above(0.0).at_most(3.0);
pub(crate) const LENGTH: Quantity = Quantity::new("a length", "m").above(0.0).at_most(100.0);
/// A place in `map`.
pub(crate) const POSITION: Quantity = Quantity::new("a position", "m")
    .at_least(-10_000.0)
    .at_most(10_000.0);
