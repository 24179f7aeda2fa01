//! Range scans: their geometry, and their alignment to the robot's motion during the sensor's turn.
//!
//! A scan takes most of a turn to measure, in which the robot drives on; at 0.4 m/s and ten turns a second that is
//! up to 40 mm. [`AlignedScan`] moves every beam to where it would lie had all been measured at one time, the
//! *reference time*, which is the time of the last beam. It gives
//! - points in `base_link` at the reference time, in the order of the beams, for perception, and
//! - ranges on the sensor's own grid of beams, seen from where the sensor stood at the reference time, for tubes.
//!
//! Raw ranges are millimetres. Codes under 20 are no lengths: 0 says that nothing reflects within range, the others
//! (1 to 19) say that the device does not know. `align` neither allocates nor blocks, and may run in a real-time
//! thread.

mod aligned;
mod geometry;

pub use aligned::{
    AlignError, AlignedScan, BeamState, FIRST_LENGTH_MM, ScanPoint, UNKNOWN_RANGE_M,
};
pub(crate) use geometry::BeamGrid;
pub use geometry::{MAX_BEAMS, ScanGeometry, ScanGeometryError};

#[cfg(test)]
mod tests;
