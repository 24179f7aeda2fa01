//! How process data is exchanged: alike for ours and for the rival.

use std::time::Duration;

use crate::bench::place::Place;

/// An answer that comes later is lost.
pub(super) const DEADLINE: Duration = Duration::from_millis(5);

/// How a MainDevice runs.
#[derive(Clone, Copy, Debug)]
pub(super) struct Cycle {
    /// From one exchange to the next.
    pub(super) period: Duration,
    /// Core and priority of its thread.
    pub(super) place: Place,
}
