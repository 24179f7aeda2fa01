//! What is said of a floor.

/// The search ends without a verdict after this many placements of robots: a bound for its time and memory.
pub(super) const MOST: usize = 300_000;
/// And after so many places of robots in them, for sites of many robots.
pub(super) const MOST_PLACES: usize = 3_000_000;

/// What was found.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Findings {
    pub(crate) verdict: Verdict,
    /// How many placements of robots and nets were looked at.
    pub(crate) looked: usize,
    /// There are no others.
    pub(crate) is_whole: bool,
    /// By robot, where others may wait for it that do not wait for ever anyway. Of a floor that was looked at in part: only robots that
    /// wait, by the order of areas, and only as far as that was.
    pub(crate) deaths: Vec<Death>,
    /// Coordinations that can stand still until their robots are told to get out of the way, or are let go. Of the whole floor only.
    pub(crate) stills: Vec<Still>,
}

/// Whether robots can come to wait for ever.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum Verdict {
    /// From every placement every robot can go on.
    Never,
    /// Robots can come to wait for ever.
    May {
        /// Shortest way there.
        steps: Vec<String>,
        waits: Vec<Waits>,
    },
    /// One robot can wait for ever while others go on.
    Starves {
        /// Shortest way to where they can go round without it.
        steps: Vec<String>,
        waits: Waits,
    },
    /// There are more placements than were looked at, and from each of these something can happen.
    Unknown {
        /// All that so many steps lead to are among those that were looked at.
        steps: usize,
    },
}

/// A robot that can never go on.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Waits {
    pub(crate) robot: String,
    pub(crate) has: Vec<String>,
    /// Areas that a net keeps for it.
    pub(crate) let_into: Vec<String>,
    pub(crate) needs: Vec<String>,
}

/// A robot dies, and others may wait for it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Death {
    pub(crate) robot: String,
    /// Areas in which it stands then.
    pub(crate) stands_in: Vec<String>,
    /// Robots that may never go on any more.
    pub(crate) robots: Vec<String>,
    /// Coordinations that may not come to a declared end any more.
    pub(crate) coordinations: Vec<String>,
    /// Shortest way to where that is so.
    pub(crate) steps: Vec<String>,
}

/// A coordination stands still.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Still {
    pub(crate) coordination: String,
    /// Shortest way there.
    pub(crate) steps: Vec<String>,
}
