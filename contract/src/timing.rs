//! Periods and timeouts on which both sides rely, in nanoseconds of each side's own monotonic clock.

/// A level is sent at least this often (5 Hz), so that the next one repairs a lost one.
pub const LEVEL_PERIOD_NS: u64 = 200_000_000;
/// A party that was not heard for longer is silent: five levels in a row were lost. A silent robot blocks what it occupies; a
/// robot whose mediator is silent stops before every border that it was not granted.
pub const SILENT_AFTER_NS: u64 = 1_000_000_000;
/// Two that speak at once for one identity for longer than this are no restart and no late message: people are told.
pub const DOUBLED_AFTER_NS: u64 = 3_000_000_000;
/// A process that asks to speak for a robot and has not repeated its session within this time is taken as gone: what asked may
/// have been a late message of a process that ended long ago.
pub const CANDIDATE_TIMEOUT_NS: u64 = 5_000_000_000;
