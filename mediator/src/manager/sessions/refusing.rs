//! Whom this mediator does not take in, and what it tells them.

use contract::floor::Floor;
use contract::wire::{MediatorReport, RobotReport};
use contract::{VERSION, Version};

use super::session::SESSIONS_PER_EPOCH;
use super::table::{Sessions, heard};
use crate::manager::alarm::Alarm;
use crate::manager::effects::Effects;

/// At most this many refusals wait to be sent; the oldest is left out and comes again with the next report.
const REFUSALS: usize = 32;

impl Sessions {
    /// Tells a process why it gets nothing.
    pub(super) fn send_refusal(&mut self, refusal: MediatorReport) {
        if self.refusals.len() == REFUSALS {
            self.refusals.remove(0);
        }
        self.refusals.push(refusal);
    }

    pub(super) fn refusal(&self, report: &RobotReport, refusal: String) -> MediatorReport {
        MediatorReport {
            version: Some(VERSION.into()),
            mediator_epoch: self.epoch,
            // The robot's own number grows, so it takes the next refusal for news too.
            sequence: report.sequence,
            robot_id: report.robot_id.clone(),
            boot_epoch: report.boot_epoch,
            refusal,
            ..MediatorReport::default()
        }
    }

    /// The next refusal of a process that does not speak for a robot of the site.
    pub(crate) fn next_refusal(&mut self) -> Option<MediatorReport> {
        self.refusals.pop()
    }

    /// No session is left that the process could be offered.
    pub(super) fn refuse_more(&mut self, report: &RobotReport, effects: &mut Effects) {
        let alarm = Alarm::TooManySessions {
            robot: report.robot_id.clone(),
            most: SESSIONS_PER_EPOCH,
        };
        self.send_refusal(self.refusal(report, alarm.to_string()));
        effects.alarms.push(alarm);
    }

    /// Tells a robot that follows another mediator, or none, that this one is not to be followed.
    pub(crate) fn stand_by(&mut self, report: &RobotReport) {
        let why = "this mediator stands by, since robots follow another one: see that this robot hears that one";
        let refusal = MediatorReport {
            stands_by: true,
            ..self.refusal(report, why.to_owned())
        };
        self.send_refusal(refusal);
    }

    /// A process reports that cannot speak for the robot now. Returns whether it is found beside the one that does, and the journal
    /// must know.
    pub(super) fn find(
        &mut self,
        robot: usize,
        report: &RobotReport,
        now_ns: u64,
        effects: &mut Effects,
    ) -> bool {
        let found = self.robots[robot].turn_away(
            report.boot_epoch,
            report.sequence,
            heard(report, self.epoch),
            now_ns,
            self.silent_after_ns,
        );
        if found {
            effects.alarms.push(Alarm::Doubled {
                robot: self.names.robot_id(robot),
            });
            effects.tell(robot);
        }
        found
    }

    /// Tells a process that another one speaks for its robot. Returns whether the journal must know.
    pub(super) fn turn_away(
        &mut self,
        robot: usize,
        report: &RobotReport,
        now_ns: u64,
        effects: &mut Effects,
    ) -> bool {
        let found = self.find(robot, report, now_ns, effects);
        let session = &mut self.robots[robot];
        session.sent += 1;
        let sequence = session.sent;
        let why = Alarm::Doubled {
            robot: self.names.robot_id(robot),
        };
        let refusal = MediatorReport {
            // One that has spoken for the robot before takes nothing older.
            sequence,
            identity_taken: true,
            ..self.refusal(report, why.to_string())
        };
        self.send_refusal(refusal);
        found
    }

    /// Whether the robot speaks our version and drives by our site; otherwise it is told why not.
    pub(super) fn admit(
        &mut self,
        robot: usize,
        report: &RobotReport,
        now_ns: u64,
        effects: &mut Effects,
    ) -> bool {
        let id = || report.robot_id.clone();
        let alarm = if let Err(mismatch) = VERSION.accept(Version::from(report.version)) {
            Some(Alarm::Version {
                robot: id(),
                mismatch,
            })
        } else if report.site != self.names.site {
            Some(Alarm::Site {
                robot: id(),
                found: report.site.clone(),
                expected: self.names.site.clone(),
            })
        } else {
            self.other_floor(report)
        };
        let session = &mut self.robots[robot];
        let Some(alarm) = alarm else {
            if !session.refusal(report.boot_epoch).is_empty() {
                session.refused = None;
                // What it was told is over; what another one was offered is not.
                (session.candidate).take_if(|own| own.boot_epoch == report.boot_epoch);
            }
            return true;
        };
        let refusal = alarm.to_string();
        // One that knows no area at all asks for the floor, which the refusal carries.
        let asks =
            matches!(alarm, Alarm::Floor { .. }) && report.floor_hash == Floor::default().hash();
        if session.refusal(report.boot_epoch) != refusal && !asks {
            effects.alarms.push(alarm);
        }
        if session.refuse(report.boot_epoch, refusal.clone(), now_ns) {
            effects.tell(robot);
        } else {
            session.sent += 1;
            let refusal = MediatorReport {
                // It has heard other messages, of a larger number perhaps than its own.
                sequence: session.sent,
                floor_hash: self.names.floor.hash(),
                floor: self.names.floor.say(),
                ..self.refusal(report, refusal)
            };
            self.send_refusal(refusal);
        }
        false
    }

    /// Whether the robot knows other areas, and which.
    fn other_floor(&self, report: &RobotReport) -> Option<Alarm> {
        let differs = self.names.floor.differs(report.floor_hash, &report.floor);
        differs.map(|difference| Alarm::Floor {
            robot: report.robot_id.clone(),
            difference,
        })
    }
}
