//! The simulated clock.

/// Where it starts: 0 means "never" to a robot.
pub const START_NS: u64 = 1_000_000_000;
/// Its step.
pub const STEP_NS: u64 = 1_000_000;

/// What a clock shows that is so far ahead of the world's, or behind it.
pub(super) fn shown_ns(world_ns: u64, ahead_ns: f64) -> u64 {
    world_ns.saturating_add_signed(ahead_ns as i64)
}
