//! What a disk that stalls makes of nobody: silent, because others were heard first, or mute, because it could not be asked.

use contract::wire::RobotReport;

use super::Manager;

/// Which of several reports that have waited is taken in first.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Precedence {
    /// Of a process that speaks for its robot, and follows this mediator.
    Speaks,
    /// Of one that speaks for its robot.
    SpeaksElsewhere,
    /// Of another process of a robot of the site.
    Beside,
    /// Of nobody that the site lists.
    Other,
}

impl Manager {
    /// Where a report comes among others that arrived while nothing was taken in: who speaks for a robot is alive before another process
    /// of that robot is judged, and who follows this mediator before those who follow another one.
    #[must_use]
    pub fn precedence(&self, report: &RobotReport) -> Precedence {
        let Some(robot) = self.names.robot(&report.robot_id) else {
            return Precedence::Other;
        };
        if !self.sessions.robot(robot).is_of(report.boot_epoch) {
            Precedence::Beside
        } else if self.peers.is_ours(report) {
            Precedence::Speaks
        } else {
            Precedence::SpeaksElsewhere
        }
    }

    /// What was to be said was written so much later, and leaves only now: robots have had no time to answer it, and coordinations none
    /// to go on.
    pub fn was_held_up(&mut self, by_ns: u64) {
        self.coordinations.put_off(by_ns);
    }
}
