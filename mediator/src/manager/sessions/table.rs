//! The sessions of all robots of the site.

use std::sync::Arc;

use contract::timing::{CANDIDATE_TIMEOUT_NS, LEVEL_PERIOD_NS};
use contract::wire::{MediatorReport, RobotReport};
use contract::{VERSION, Version};

use super::factsheet::Factsheet;
use super::numbers::Belief;
use super::session::Session;
use crate::manager::alarm::Alarm;
use crate::manager::effects::Effects;
use crate::manager::names::Names;
use crate::setup::LONGEST_REACH_M;

/// The levels of so many robots are repeated at once in any case.
const REPEATED_AT_ONCE: usize = 16;
/// Those of all are repeated in this time: as many as are due in it are four fifths of all.
const ALL_REPEATED_NS: u64 = LEVEL_PERIOD_NS / 5 * 4;

/// What became of a report's head.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Recognised {
    /// The session has changed, and must be stored.
    pub(crate) changed: bool,
    /// Another process speaks for the robot from now on.
    pub(crate) promoted: bool,
    /// What the report says counts.
    pub(crate) counts: bool,
}

/// Who speaks for each robot.
#[derive(Clone, Debug)]
pub(crate) struct Sessions {
    pub(super) names: Arc<Names>,
    /// Number of this start of the mediator.
    pub(crate) epoch: u64,
    pub(super) silent_after_ns: u64,
    pub(super) robots: Vec<Session>,
    /// Robots that have not said since the start where they stand, or are not accounted for. As long as there are some, nothing
    /// is granted.
    pub(super) awaited: Vec<usize>,
    /// Which robot's levels are repeated first, and when that was looked at last.
    repeats: (usize, u64),
    /// For robots that the site does not list, and processes that do not speak for theirs.
    pub(super) refusals: Vec<MediatorReport>,
}

impl Sessions {
    pub(crate) fn new(names: &Arc<Names>, epoch: u64, silent_after_ns: u64, now_ns: u64) -> Self {
        Self {
            epoch,
            silent_after_ns,
            robots: vec![Session::new(now_ns); names.robots().len()],
            awaited: Vec::new(),
            repeats: (0, now_ns),
            refusals: Vec::new(),
            names: Arc::clone(names),
        }
    }

    pub(crate) fn robot(&self, robot: usize) -> &Session {
        &self.robots[robot]
    }

    pub(crate) fn robot_mut(&mut self, robot: usize) -> &mut Session {
        &mut self.robots[robot]
    }

    pub(crate) fn is_heard(&self, robot: usize) -> bool {
        self.robots[robot].is_heard()
    }

    /// A candidate was told of levels that have changed since; it must register again and hear the present ones.
    pub(crate) fn drop_candidate(&mut self, robot: usize) {
        self.robots[robot].candidate = None;
    }

    // ---------------------------------------------------------------- reports

    /// Which robot a report is of. One that the site does not list is refused, and a number that no process can have reached dropped.
    pub(crate) fn identify(
        &mut self,
        report: &RobotReport,
        now_ns: u64,
        effects: &mut Effects,
    ) -> Option<usize> {
        let Some(robot) = self.names.robot(&report.robot_id) else {
            effects.counters.bad += 1;
            let alarm = Alarm::UnknownRobot(report.robot_id.clone());
            self.send_refusal(self.refusal(report, alarm.to_string()));
            effects.alarms.push(alarm);
            return None;
        };
        let own = &mut self.robots[robot];
        let newest = if own.is_of(report.boot_epoch) {
            own.sequence
        } else {
            0
        };
        let believed = (own.numbers).judge(newest, report, now_ns, self.silent_after_ns);
        if believed == Belief::Yes {
            return Some(robot);
        }
        effects.counters.bad += 1;
        if believed == Belief::No {
            effects.alarms.push(Alarm::MadeUpNumber {
                robot: self.names.robot_id(robot),
                found: report.sequence,
            });
        }
        None
    }

    /// Judges the head of a report: whether it is of the process that speaks for the robot, in its order, and meant for this
    /// start of the mediator. `ours`: the robot follows no other one.
    pub(crate) fn recognise(
        &mut self,
        robot: usize,
        report: &RobotReport,
        ours: bool,
        now_ns: u64,
        effects: &mut Effects,
    ) -> Recognised {
        let mut recognised = Recognised::default();
        if self.robots[robot].is_retired(report.boot_epoch) {
            effects.counters.stale += 1;
            self.turn_away(robot, report, now_ns, effects);
            return recognised;
        }
        self.robots[robot].reports = true;
        self.robots[robot].reports_here |= report.site == self.names.site;
        self.robots[robot].knows_floor = report.floor_hash == self.names.floor.hash();
        let admitted = self.admit(robot, report, now_ns, effects);
        let epoch = self.epoch;
        let session = &mut self.robots[robot];
        let present = session.is_of(report.boot_epoch);
        if !present && session.is_alive(now_ns) && report.site == self.names.site {
            recognised.changed = if admitted {
                self.turn_away(robot, report, now_ns, effects)
            } else {
                // It has heard why. Its body is another one all the same.
                self.find(robot, report, now_ns, effects)
            };
            return recognised;
        }
        if !admitted {
            return recognised;
        }
        let candidate = { session.candidate }
            .filter(|candidate| candidate.boot_epoch == report.boot_epoch && !present);
        if let Some(candidate) = candidate {
            if !ours || report.session != candidate.session || report.mediator_epoch != epoch {
                effects.tell(robot);
                return recognised;
            }
            session.promote(candidate, now_ns);
            (recognised.changed, recognised.promoted) = (true, true);
        } else if !present {
            if session.invite(report.boot_epoch, epoch, now_ns) {
                effects.tell(robot);
                recognised.changed = true;
            } else if session.has_used_up(epoch) {
                self.refuse_more(report, effects);
            }
            return recognised;
        }
        if report.sequence <= session.sequence {
            effects.counters.stale += 1;
            return recognised;
        }
        let until_ns = now_ns.saturating_add(self.silent_after_ns);
        session.lives(until_ns, echo(report, epoch));
        if !ours || report.session != session.number || report.mediator_epoch != epoch {
            // It has not heard of this session yet: what it says may be from before.
            session.say_all();
            effects.tell(robot);
            return recognised;
        }
        // One that does not count is told to nobody: were it of somebody else, the robot could not go on from there.
        session.sequence = report.sequence;
        session.without_control = report.without_control;
        if let Some(told) = &report.factsheet {
            let told = Some(Factsheet::of(told));
            if session.factsheet != told {
                session.factsheet = told;
                effects.alarms.extend(too_large(session, report));
            }
        }
        recognised.counts = true;
        recognised
    }

    /// Whether a second process runs beside the one that speaks for the robot.
    pub(crate) fn is_doubled(&self, robot: usize, now_ns: u64) -> bool {
        self.robots[robot].is_doubled(now_ns, self.silent_after_ns)
    }

    /// Whether the report may be of a living process beside the one that speaks for the robot.
    pub(crate) fn may_be_second(&self, robot: usize, report: &RobotReport) -> bool {
        self.robots[robot].may_be_second(report.boot_epoch, heard(report, self.epoch))
    }

    /// The report is of a process that has heard what was said after the one was taken in that speaks for the robot: both live.
    pub(crate) fn hears_since_taken_in(&self, robot: usize, report: &RobotReport) -> bool {
        let at = self.robots[robot].taken_in_at;
        at > 0 && heard(report, self.epoch).is_some_and(|echo| echo > at)
    }

    /// Whoever is heard now counts as heard until then.
    pub(crate) fn heard_until_ns(&self, now_ns: u64) -> u64 {
        now_ns.saturating_add(self.silent_after_ns)
    }

    // ---------------------------------------------------------------- time

    /// Whether a robot has fallen silent now.
    pub(crate) fn falls_silent(&mut self, robot: usize, now_ns: u64) -> bool {
        let session = &mut self.robots[robot];
        let late = now_ns > session.heard_ns.saturating_add(self.silent_after_ns);
        let falls_silent = session.is_heard() && late;
        session.silent |= falls_silent;
        falls_silent
    }

    /// Gives up candidates that have not come back, and repeats levels. Not of all robots at once, so that news need not wait for
    /// a thousand repetitions: as many as are due in the time since the last look, and a quarter more.
    pub(crate) fn keep_up(&mut self, now_ns: u64, effects: &mut Effects) {
        let count = self.robots.len();
        let (first, before_ns) = self.repeats;
        let since_ns = now_ns.saturating_sub(before_ns);
        let mut room = share(count, since_ns).max(REPEATED_AT_ONCE);
        let mut next = first;
        for robot in (first..count).chain(0..first) {
            let session = &mut self.robots[robot];
            session.candidate = { session.candidate }
                .filter(|candidate| now_ns < candidate.since_ns + CANDIDATE_TIMEOUT_NS);
            let somebody = session.number > 0 || session.candidate.is_some();
            let due = somebody && now_ns >= session.sent_ns.saturating_add(LEVEL_PERIOD_NS);
            if due && room > 0 {
                room -= 1;
                next = robot + 1;
                effects.tell(robot);
            }
        }
        self.repeats = (next % count.max(1), now_ns);
    }

    // ---------------------------------------------------------------- messages

    /// The next process to tell: its robot, boot epoch and session.
    pub(crate) fn next_listener(
        &mut self,
        now_ns: u64,
        effects: &mut Effects,
    ) -> Option<(usize, u64, u64)> {
        let robot = loop {
            let robot = effects.next_to_tell()?;
            if self.robots[robot].reports {
                break robot;
            }
            effects.told();
        };
        let session = &mut self.robots[robot];
        session.sent += 1;
        if let Some(candidate) = session.candidate
            && effects.take_candidate_news(robot)
        {
            if session.number == 0 {
                effects.told();
                session.sent_ns = now_ns;
            }
            return Some((robot, candidate.boot_epoch, candidate.session));
        }
        effects.told();
        session.sent_ns = now_ns;
        Some((robot, session.boot_epoch, session.number))
    }
}

/// The levels of how many of so many robots are due in a time, and a quarter more; at most those of all. Rounded up, and exact: no product
/// exceeds the number of robots, or the square of [`ALL_REPEATED_NS`].
fn share(count: usize, since_ns: u64) -> usize {
    if since_ns >= ALL_REPEATED_NS {
        return count;
    }
    let count = count as u64;
    let (whole, rest) = (count / ALL_REPEATED_NS, count % ALL_REPEATED_NS);
    (whole * since_ns + (rest * since_ns).div_ceil(ALL_REPEATED_NS)) as usize
}

/// That; none of one of another version, which takes no message in.
pub(super) fn heard(report: &RobotReport, epoch: u64) -> Option<u64> {
    let understands = VERSION.accept(Version::from(report.version)).is_ok();
    understands.then(|| echo(report, epoch))
}

/// The newest message of this start of the mediator that the sender has heard.
fn echo(report: &RobotReport, epoch: u64) -> u64 {
    if report.mediator_epoch == epoch {
        report.mediator_sequence
    } else {
        0
    }
}

/// Until a robot is heard it is taken to be within a distance of its start; one that reaches farther may be elsewhere, too.
fn too_large(session: &Session, report: &RobotReport) -> Option<Alarm> {
    let reach_m = session.factsheet.as_ref()?.reach_m();
    (reach_m > LONGEST_REACH_M).then(|| Alarm::TooLarge {
        robot: report.robot_id.clone(),
        reach_m,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_share_is_exact_for_any_number_of_robots_after_any_time() {
        let times_ns = [0, 1, 7, ALL_REPEATED_NS - 1, ALL_REPEATED_NS, u64::MAX];
        for count in [0, 1, 1_000, ALL_REPEATED_NS as usize + 7, usize::MAX] {
            for since_ns in times_ns {
                // After a period all are due.
                let quarters = count as u128 * u128::from(since_ns.min(LEVEL_PERIOD_NS)) * 5;
                let due = quarters.div_ceil(u128::from(LEVEL_PERIOD_NS) * 4);
                let expected = due.min(count as u128) as usize;
                assert_eq!(share(count, since_ns), expected, "{count}, {since_ns} ns");
            }
        }
    }
}
