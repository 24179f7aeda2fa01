//! Mediators that a robot does not follow, or not any more.

use std::collections::VecDeque;

use crate::timing::SILENT_AFTER_NS;

/// So many of those that were followed before are remembered.
const MEDIATORS: usize = 8;

/// Other mediators that speak to this robot.
#[derive(Clone, Copy, Debug)]
pub(super) struct Other {
    pub(super) since_ns: u64,
    pub(super) heard_ns: u64,
    /// When one was heard last that may grant something.
    pub(super) grants_ns: Option<u64>,
}

impl Other {
    pub(super) fn is_heard(&self, now_ns: u64) -> bool {
        now_ns <= self.heard_ns.saturating_add(SILENT_AFTER_NS)
    }

    pub(super) fn may_grant(&self, now_ns: u64) -> bool {
        { self.grants_ns }.is_some_and(|at_ns| now_ns <= at_ns.saturating_add(SILENT_AFTER_NS))
    }
}

/// Mediators that were followed before the present one, with epoch and sequence of what was heard of them last: what is older still comes
/// late, and counts on what the robot has forgotten since.
#[derive(Clone, Debug, Default)]
pub(super) struct Before(VecDeque<(u64, (u64, u64))>);

impl Before {
    /// Epoch and sequence of the newest message of this one; zeros of one that was not followed.
    pub(super) fn newest_of(&self, instance: u64) -> (u64, u64) {
        let known = self.0.iter().find(|(own, _)| *own == instance);
        known.map_or((0, 0), |(_, newest)| *newest)
    }

    /// This one is followed no more.
    pub(super) fn add(&mut self, instance: u64, newest: (u64, u64)) {
        self.0.retain(|(own, _)| *own != instance);
        self.0.truncate(MEDIATORS - 1);
        self.0.push_front((instance, newest));
    }
}
