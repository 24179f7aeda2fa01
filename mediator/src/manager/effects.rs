//! What a step leaves behind: entries to write, alarms to raise, robots to tell.

use super::alarm::Alarm;
use crate::journal::Entry;

/// Counts since the start.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counters {
    /// Reports taken in.
    pub reports: u64,
    /// Reports from before: of an earlier boot or session, or with an old sequence number.
    pub stale: u64,
    /// Parts of reports that made no sense.
    pub bad: u64,
    /// Levels about another grant than the present one.
    pub other_fence: u64,
    /// Grants given.
    pub grants: u64,
    /// Requests taken in.
    pub requests: u64,
    /// Grants asked back.
    pub revocations: u64,
    /// Areas given back.
    pub given_back: u64,
    /// Levels taken over from a robot because the journal was behind.
    pub adopted: u64,
    /// Runs that an operator cleared.
    pub cleared: u64,
    /// New processes of robots that stood where the one before cannot have come to.
    pub elsewhere: u64,
    /// Robots looked at to decide which mediator goes on, and who plays a role: as many for each report, however many robots the
    /// site has.
    pub looks: u64,
    /// Coordinations let go on: those for which a report is news, however many run.
    pub steps: u64,
}

/// What is to be done outside, in the order in which it came up.
#[derive(Clone, Debug)]
pub(crate) struct Effects {
    pub(crate) entries: Vec<Entry>,
    pub(crate) alarms: Vec<Alarm>,
    pub(crate) counters: Counters,
    /// Robots to tell, each once; the last is told first.
    to_tell: Vec<usize>,
    robots: Vec<News>,
}

/// What one robot has not been told.
#[derive(Clone, Copy, Debug, Default)]
struct News {
    /// It is listed in `to_tell`.
    listed: bool,
    /// Nor has the process that asks to speak for it.
    candidate: bool,
}

impl Effects {
    pub(crate) fn new(robots: usize) -> Self {
        Self {
            entries: Vec::new(),
            alarms: Vec::new(),
            counters: Counters::default(),
            to_tell: Vec::new(),
            robots: vec![News::default(); robots],
        }
    }

    /// There is news for a robot, and for the process that asks to speak for it.
    pub(crate) fn tell(&mut self, robot: usize) {
        let news = &mut self.robots[robot];
        news.candidate = true;
        if !std::mem::replace(&mut news.listed, true) {
            self.to_tell.push(robot);
        }
    }

    /// The next robot to tell.
    pub(crate) fn next_to_tell(&self) -> Option<usize> {
        self.to_tell.last().copied()
    }

    /// Whether the process that asks to speak for a robot has not been told; from now on it has.
    pub(crate) fn take_candidate_news(&mut self, robot: usize) -> bool {
        std::mem::take(&mut self.robots[robot].candidate)
    }

    /// The [next robot](Self::next_to_tell) has been told.
    pub(crate) fn told(&mut self) {
        if let Some(robot) = self.to_tell.pop() {
            self.robots[robot].listed = false;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_robot_is_listed_once_and_its_candidate_is_told_apart() {
        let mut effects = Effects::new(2);
        for robot in [0, 1, 0] {
            effects.tell(robot);
        }
        assert_eq!(effects.next_to_tell(), Some(1));
        effects.told();
        assert_eq!(effects.next_to_tell(), Some(0));
        assert!(effects.take_candidate_news(0) && !effects.take_candidate_news(0));
        effects.told();
        assert_eq!(effects.next_to_tell(), None);
        effects.tell(0);
        assert_eq!(effects.next_to_tell(), Some(0));
    }
}
