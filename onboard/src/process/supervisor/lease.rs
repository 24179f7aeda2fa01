//! The robot is in somebody's hands.

/// The session of who drives it by hand.
#[derive(Clone, Copy, Debug)]
pub(super) struct Lease {
    /// Its number.
    pub(super) session: u64,
    /// When it began.
    pub(super) since_ns: u64,
}
