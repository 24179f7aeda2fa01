//! What the tubes answer: verdicts, reasons, refused scans, counters.

use crate::tubes::set::tube_set::TubeId;
use description::geometry::MotionCommand;
use thiserror::Error;

/// How a wanted command was changed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[repr(u8)]
pub enum Verdict {
    /// Driven as wanted.
    Free,
    /// At another curvature within the band; perhaps slower, too.
    Shifted,
    /// At the wanted curvature, slower.
    Slowed,
    /// Not driven.
    #[default]
    Stopped,
}

/// Why a command is not driven as wanted.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[repr(u8)]
pub enum Reason {
    /// It is.
    None,
    /// Tubes of the wanted length, speed or curvature are not free.
    Blocked,
    /// No tube of the set has the wanted curvature.
    BeyondTubes,
    /// A tube is free, and not yet for long enough.
    Resuming,
    /// No valid scan for too long, or never.
    #[default]
    NoScan,
    /// Scans are good, and not yet for long enough.
    AwaitingScans,
    /// The robot is too fast to stop inside what is free.
    TooFast,
    /// The set has no tube that is driven backwards.
    Backwards,
    /// A number of the command is NaN or infinite.
    NotFinite,
    /// Something moves, and could arrive before the robot stands.
    Moving,
    /// The floor behind was neither seen free nor driven over.
    UnknownFloor,
    /// It must come to rest before it reverses.
    Reversing,
}

impl Reason {
    /// All, in the order of their numbers.
    pub const ALL: [Self; 12] = [
        Self::None,
        Self::Blocked,
        Self::BeyondTubes,
        Self::Resuming,
        Self::NoScan,
        Self::AwaitingScans,
        Self::TooFast,
        Self::Backwards,
        Self::NotFinite,
        Self::Moving,
        Self::UnknownFloor,
        Self::Reversing,
    ];

    /// In words, for people.
    #[must_use]
    pub const fn words(self) -> &'static str {
        match self {
            Self::None => "nothing is in the way",
            Self::Blocked => "something is in the way",
            Self::BeyondTubes => "no motion tube turns so tightly",
            Self::Resuming => "the way is free again, and not yet for long enough",
            Self::NoScan => "no valid scan arrives",
            Self::AwaitingScans => "scans are good again, and not yet for long enough",
            Self::TooFast => "the robot is too fast to stop in what is free",
            Self::Backwards => "this robot has no motion tubes backward",
            Self::NotFinite => "the motion is no number",
            Self::Moving => "something moves nearby",
            Self::UnknownFloor => "the floor there was not seen to be free",
            Self::Reversing => "it must come to rest first",
        }
    }
}

/// The command to drive, and what led to it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Adapted {
    /// What to drive. A stop keeps the curvature, so that the robot halts on its path.
    pub command: MotionCommand,
    /// What became of the wanted command.
    pub verdict: Verdict,
    /// Why.
    pub reason: Reason,
    /// The tube that it is driven in.
    pub tube: Option<TubeId>,
    /// How far ahead it is known to be free; 0 without a tube.
    pub length_m: f64,
    /// From the footprint to the nearest hit of the newest scan; infinite when there is none.
    pub clearance_m: f64,
    /// The same, of what moves.
    pub moving_m: f64,
    /// Age of that scan; the largest number when there is none.
    pub scan_age_ns: u64,
    /// Since when it has been stopped; 0 while it is not.
    pub stopped_since_ns: u64,
}

/// Why a scan was not judged.
#[derive(Clone, Copy, Debug, Error, PartialEq, Eq)]
#[expect(missing_docs, reason = "the messages say what each field is")]
pub enum ObserveError {
    /// It holds no scan.
    #[error("the scan is empty")]
    Empty,
    /// Another sensor than the tubes were made for.
    #[error("the scan has another geometry than the tubes")]
    Geometry,
    /// Not newer than the one before.
    #[error("scan of {reference_ns} ns is not after the one before, {previous_ns} ns")]
    NotAfter { reference_ns: u64, previous_ns: u64 },
    /// From too long ago, or from the future.
    #[error("scan of {reference_ns} ns is not of now, {now_ns} ns")]
    NotOfNow { reference_ns: u64, now_ns: u64 },
}

/// Counts since the start.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counters {
    /// Scans judged.
    pub scans: u64,
    /// Scans refused.
    pub refused: u64,
    /// Stops because no tube was free.
    pub blocked_stops: u64,
    /// Stops because of missing scans.
    pub blind_stops: u64,
    /// Stops because something moved nearby.
    pub moving_stops: u64,
    /// Detours begun around standing obstacles.
    pub detours: u64,
    /// Detours that changed to the other side.
    pub detour_side_changes: u64,
    /// Retreats begun from dead ends.
    pub retreats: u64,
    /// Jumps of the odometry, or of the clock, after which everything remembered was forgotten.
    pub jumps: u64,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn reasons_are_in_the_order_of_their_numbers() {
        for (number, reason) in Reason::ALL.into_iter().enumerate() {
            assert_eq!(reason as usize, number);
        }
    }
}
