//! Periods and timeouts on which both sides rely, in nanoseconds of each side's own monotonic clock.

/// A level is sent at least this often (5 Hz), so that the next one repairs a lost one.
pub const LEVEL_PERIOD_NS: u64 = 200_000_000;
/// A party that was not heard for longer is silent: five levels in a row were lost. A silent robot blocks what it occupies; a
/// robot whose mediator is silent stops before every border that it was not granted.
pub const SILENT_AFTER_NS: u64 = 1_000_000_000;
/// How long a robot may newly enter what it was granted after it has sent the newest report that its mediator says it has.
pub const LEASE_NS: u64 = 1_000_000_000;
/// A robot's process that was just registered enters nothing for so long: by then it has heard whether another mediator speaks to it, too.
pub const LISTENS_FIRST_NS: u64 = 1_000_000_000;
/// The longest time from when a robot may still pass its point of no return before an area until it has entered the area or
/// stands before it: it obeys the end of its lease, or drives on into the area, at whatever speed.
pub const ENTERS_WITHIN_NS: u64 = 3_900_000_000;
/// A robot that was not heard for this long enters no area any more that it has not entered, whatever it was granted: its lease
/// and the time to use it, and what two clocks may differ by meanwhile (20 000 ppm; crystals have 100).
pub const ENTERS_NO_MORE_NS: u64 = LEASE_NS + ENTERS_WITHIN_NS + 100_000_000;
/// A robot that has kept an area that was asked back, and is not in it this much later, could not stop before it then and can by now:
/// it is asked again.
pub const ASKED_AGAIN_NS: u64 = 1_000_000_000;
/// A robot that has not answered `acquire` after this time does not hold the others any more: its coordination ends.
pub const ACQUIRED_WITHIN_NS: u64 = 5_000_000_000;
/// Two that speak at once for one identity for longer than this are no restart and no late message: people are told.
pub const DOUBLED_AFTER_NS: u64 = 3_000_000_000;
/// A process that asks to speak for a robot and has not repeated its session within this time is taken as gone: what asked may
/// have been a late message of a process that ended long ago.
pub const CANDIDATE_TIMEOUT_NS: u64 = 5_000_000_000;
