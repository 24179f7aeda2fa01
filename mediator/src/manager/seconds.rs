//! Second processes with the name of a robot: each is another body, wherever it says that it stands. So is one before, if the robot's new
//! one stands where that cannot have come to.

use contract::wire::RobotReport;

use super::alarm::Alarm;
use super::areas::{Known, SecondHeard, Speaker};
use super::names::second_of;
use super::routing::Manager;

impl Manager {
    /// The report is of a process that does not speak for the robot: wherever it stands, nobody is let in.
    /// `alone`: none that does is heard, and this one is refused.
    pub(super) fn hold_for_second(
        &mut self,
        robot: usize,
        report: &RobotReport,
        alone: bool,
        now_ns: u64,
    ) {
        if report.site != self.names.site {
            return;
        }
        let session = self.sessions.robot(robot);
        let known = if session.was_found(report.boot_epoch) {
            Known::Found
        } else if alone {
            Known::Alone
        } else {
            Known::Nothing
        };
        // One that was found before never speaks for the robot, whoever is heard: it stays another body.
        let speaks = session.is_alive(now_ns) || session.is_heard();
        let beside = speaks || session.is_retired(report.boot_epoch);
        let lives = self.sessions.hears_since_taken_in(robot, report);
        let heard = SecondHeard {
            known,
            beside,
            lives,
        };
        let until_ns = self.sessions.heard_until_ns(now_ns);
        if (self.areas).hold_for_second(robot, report, heard, until_ns) {
            self.store_robot(robot);
        }
    }

    /// The process that speaks for the robot, until another one does.
    pub(super) fn speaker(&self, robot: usize) -> Option<Speaker> {
        let session = self.sessions.robot(robot);
        (session.number > 0).then_some(Speaker {
            process: session.boot_epoch,
            sequence: session.sequence,
        })
    }

    /// The process that speaks for the robot has said where it stands, if it knows: the one before, whose next one it is not, is another body.
    /// Returns whether the journal must know.
    pub(super) fn judge_before(&mut self, robot: usize) -> bool {
        let former = self.areas.judge_before(robot, &mut self.effects);
        if let Some(process) = former.another {
            self.sessions.robot_mut(robot).note_another(process);
        }
        former.is_news
    }

    /// Robots follow another mediator, so nobody is taken in here. Where those are that were found is known when this one goes on.
    pub(super) fn stand_by(&mut self, robot: usize, report: &RobotReport, now_ns: u64) {
        if self.sessions.robot(robot).was_found(report.boot_epoch) {
            self.hold_for_second(robot, report, false, now_ns);
        }
        self.sessions.stand_by(report);
    }

    /// Ends the holds of those that were heard too long ago, and tells people of those that were found: what these hold stays blocked.
    pub(super) fn look_after_seconds(&mut self, robot: usize, now_ns: u64) {
        let dropped = self.areas.drop_silent_seconds(robot, now_ns);
        if !dropped.areas.is_empty() {
            self.coordinations.look_again_at(robot);
        }
        if dropped.found {
            self.store_robot(robot);
        }
        if self.peers.stands_by {
            // What people are told to do they could not do here.
            return;
        }
        let silent = self.areas.seconds_that_fall_silent(robot, now_ns);
        if !silent.is_empty() {
            self.effects.alarms.push(Alarm::SilentSecond {
                robot: self.names.robot_id(robot),
                areas: self.names.area_list(silent),
            });
        }
    }

    /// Second processes of these robots that are not heard are not in the area. Returns them, for people. Whoever is
    /// heard there stays, or the area could never be cleared of them while others wait in it for each other.
    pub(super) fn clear_of_seconds(
        &mut self,
        of: &[usize],
        area: usize,
        now_ns: u64,
    ) -> Vec<String> {
        let mut cleared = Vec::new();
        for &robot in of {
            if self.areas.clear_of_seconds(robot, area, now_ns) {
                self.coordinations.look_again_at(robot);
                self.store_robot(robot);
                cleared.push(second_of(&self.names.robot_id(robot)));
            }
        }
        if !cleared.is_empty() {
            self.go_on(now_ns);
        }
        cleared
    }
}
