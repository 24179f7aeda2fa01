//! The simulated clock.

/// Where it starts: 0 means "never" to a robot.
pub const START_NS: u64 = 1_000_000_000;
/// Its step.
pub const STEP_NS: u64 = 1_000_000;
