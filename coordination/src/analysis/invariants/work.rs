//! How much a search for invariants may still look at.

/// Numbers that may still be looked at: a bound for time, and for the memory of what is made of them.
pub(super) struct Work {
    left: u64,
}

/// An entry that is made takes as long as looking at so many, and sixteen bytes.
pub(super) const MADE: usize = 8;

impl Work {
    pub(super) fn new(left: u64) -> Self {
        Self { left }
    }

    /// Whether so many may be looked at. After the first that may not, none may.
    pub(super) fn take(&mut self, count: usize) -> bool {
        let left = self.left.checked_sub(count as u64);
        self.left = left.unwrap_or(0);
        left.is_some()
    }
}
