//! What a robot says of itself, and what is counted.

use crate::wire::Pose;

/// What the robot knows of itself.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Situation {
    /// The pose is certain enough to say in which areas the robot stands.
    pub located: bool,
    /// Areas that the footprint, with a margin for the pose's uncertainty, reaches into.
    pub stands_in: Vec<String>,
    /// Areas that the robot wants to have now, those it stands in included, in the order of asking.
    pub wanted: Vec<String>,
    /// Areas that it can no longer stop before.
    pub committed: Vec<String>,
    /// Where it is.
    pub pose: Option<Pose>,
    /// State of its machine.
    pub fsm_state: String,
}

impl Situation {
    /// It stands in the area, or can no longer stop before it.
    pub(super) fn needs(&self, area: &String) -> bool {
        self.stands_in.contains(area) || self.committed.contains(area)
    }
}

/// Counts since the start.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ClientCounters {
    /// Messages from the past.
    pub stale: u64,
    /// Messages with numbers that no mediator has.
    pub nonsense: u64,
    /// Levels that could not follow on ours.
    pub bad_levels: u64,
    /// Grants received.
    pub grants: u64,
    /// Grants that the mediator took away.
    pub aborted: u64,
    /// Grants given back because the mediator asked.
    pub yielded: u64,
    /// Grants kept although the mediator asked.
    pub kept: u64,
    /// Orders handed out.
    pub orders: u64,
    /// Coordinations that ended without a release: the mediator knows nothing of them.
    pub let_go: u64,
}
