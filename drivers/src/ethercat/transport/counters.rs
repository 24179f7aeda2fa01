//! What is counted while frames are carried.

/// What happened since bring-up.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct BusCounters {
    /// Exchanges begun.
    pub cycles: u64,
    /// Exchanges without an answer by the deadline.
    pub lost_frames: u64,
    /// Answers with a wrong working counter.
    pub wkc_errors: u64,
    /// Answers from a SubDevice that was not in OP.
    pub not_operational: u64,
    /// Exchanges that the link or the protocol ended.
    pub errors: u64,
    /// Frames received that were whole but no answer to the current one: late, duplicated or of somebody else.
    pub foreign_frames: u64,
    /// Frames received that no SubDevice had touched.
    pub echoed_frames: u64,
    /// Frames received that were damaged.
    pub malformed_frames: u64,
}
