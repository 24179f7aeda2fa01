//! The simulated clock, and those of the robots' computers: each counts from when it was switched on.

use sim::world::Random;

/// Where it starts: 0 means "never" to a robot.
pub const START_NS: u64 = 1_000_000_000;
/// Its step.
pub const STEP_NS: u64 = 1_000_000;

/// What a clock shows that is so far ahead of the world's, or behind it.
pub(super) fn shown_ns(world_ns: u64, ahead_ns: f64) -> u64 {
    world_ns.saturating_add_signed(ahead_ns as i64)
}

/// How far the clock of a computer is ahead of the world's that has run for up to a day already, in whole nanoseconds.
pub(super) fn drawn_ahead_ns(random: &mut Random) -> f64 {
    const DAY_NS: f64 = 86_400e9;
    (random.unit() * DAY_NS).round()
}

/// The same of one that is switched on now, by when a process runs on it.
pub(super) fn ahead_after_boot_ns(world_ns: u64) -> f64 {
    const BOOT_NS: f64 = 3e9;
    BOOT_NS - world_ns as f64
}
