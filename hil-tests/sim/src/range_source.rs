//! The seam between a simulated lidar and what it measures.

/// Steps of a whole turn.
pub const STEPS_PER_TURN: usize = 1024;
/// Steps that can be asked for: 0 to 768.
pub const RANGE_STEPS: usize = 769;

/// Where a lidar's readings come from.
pub trait RangeSource: Send {
    /// Fills in the readings of the turn that began at `turn_start_ns` (step 0, monotonic): millimetres, or error
    /// codes under 20. Called after the last step was measured, three quarters of a turn later.
    fn measure(&mut self, turn_start_ns: u64, turn_ns: u64, readings_mm: &mut [u16; RANGE_STEPS]);
}
