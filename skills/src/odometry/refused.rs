//! Samples that are not used: why, and how many.

/// Why a sample was not used.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum OdometryFault {
    /// A value was not a number.
    #[error("encoder sample at {stamp_ns} ns is not finite")]
    NotFinite {
        /// Stamp of the sample.
        stamp_ns: u64,
    },
    /// The stamp lies before the last accepted one.
    #[error("encoder sample is {by_ns} ns older than the one before")]
    TimeBackwards {
        /// By how much.
        by_ns: u64,
    },
    /// After a long gap the encoders said what is not possible.
    #[error("no encoder sample for {gap_s:.2} s, and then one that does not follow from the last")]
    Gap {
        /// How long.
        gap_s: f64,
    },
    /// A wheel moved farther than it can.
    #[error(
        "wheel encoders moved {left_rad:.3} and {right_rad:.3} rad, at most {limit_rad:.3} is possible"
    )]
    WheelJump {
        /// Left increment.
        left_rad: f64,
        /// Right increment.
        right_rad: f64,
        /// What the wheel speed limit allows.
        limit_rad: f64,
    },
    /// The pivot moved in a way that the wheels do not explain.
    #[error("pivot encoder moved {moved_rad:.3} rad, the wheels explain {explained_rad:.3}")]
    PivotJump {
        /// Increment of the pivot.
        moved_rad: f64,
        /// What follows from the wheels.
        explained_rad: f64,
    },
}

/// How many samples were used and rejected.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct OdometryCounters {
    /// Used.
    pub accepted: u64,
    /// Same stamp as the one before, nothing to do.
    pub repeated: u64,
    /// Not a number.
    pub not_finite: u64,
    /// Stamp before the last one.
    pub time_backwards: u64,
    /// Gaps in time.
    pub gaps: u64,
    /// Impossible increments of wheels or pivot.
    pub jumps: u64,
}

impl OdometryCounters {
    /// All that were rejected.
    #[must_use]
    pub fn rejected(&self) -> u64 {
        self.not_finite + self.time_backwards + self.gaps + self.jumps
    }
}
