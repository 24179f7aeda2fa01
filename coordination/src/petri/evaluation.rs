//! How much an evaluation may do, and what it did.

/// How much one evaluation may do.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Budget {
    /// The most firings.
    pub firings: u32,
    /// The most rounds; in one round each transition fires at most once.
    pub rounds: u32,
}

impl Budget {
    /// At most one firing.
    pub const ONE: Self = Self {
        firings: 1,
        rounds: 1,
    };
    /// One round: until every enabled transition has fired.
    pub const ROUND: Self = Self {
        firings: u32::MAX,
        rounds: 1,
    };
}

impl Default for Budget {
    /// One round.
    fn default() -> Self {
        Self::ROUND
    }
}

/// What one evaluation did.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Evaluation {
    /// How many transitions fired.
    pub fired: u32,
    /// A transition is enabled, or an empty source has an event waiting: the next evaluation has
    /// something to do. Also if the search for an enabled transition was cut short; see
    /// [`Executor::limit_search`](super::Executor::limit_search).
    pub remaining: bool,
}

/// How much may still happen in an evaluation.
#[derive(Clone, Copy, Debug)]
pub(in crate::petri) struct Allowance {
    pub(in crate::petri) firings: u32,
    pub(in crate::petri) rounds: u32,
    /// Looks in vain; a search ends when they are used up, but not before its first one.
    pub(in crate::petri) looks: u32,
}
