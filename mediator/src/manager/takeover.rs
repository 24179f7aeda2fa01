//! What robots may have that this mediator does not know of, and what an operator says of them.
//!
//! At every start all robots of the site are *awaited*: nothing is granted until each has said where it stands, or an operator that
//! it is absent. So a journal that has lost its last entries, or is older, lets nobody in where another robot is. What was said of
//! absence before the start counts if nobody hears the robot, and only once a grant that the journal has lost is over.
//!
//! Another mediator may have granted anything to anybody: it has another journal, which this one replaces or comes back after, or
//! this mediator has stood by. Then no robot is *accounted for* until it has followed this mediator and said what it has, which
//! counts whatever was known of it here. From then on this mediator has a larger epoch: larger than that of the mediator that is
//! gone, since robots follow another one only then, and larger than its own before. So whoever repeats it has taken in all that
//! was on its way to it. Nobody gets a lease for what it has from this mediator while any robot is awaited, or while it stands by: another
//! one may only be out of reach, and take what it has granted from a robot that it does not hear.
//!
//! A grant that was not entered is a lease: a robot enters nothing more once it has not been heard for
//! [`ENTERS_NO_MORE_NS`]. Before that nobody takes such a grant from it: no operator, and no new process of it.

use std::time::Duration;

use contract::timing::ENTERS_NO_MORE_NS;
use contract::wire::RobotReport;

use super::alarm::Alarm;
use super::error::{AbsentError, ClearError, EndError, NotRunning, StandsBy, UnknownRobot};
use super::names::second_of;
use super::routing::Manager;
use crate::journal::Entry;

/// What an operator has cleared an area of.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Cleared {
    /// Robots that are not in it, and second processes of robots, for people.
    pub of: Vec<String>,
    /// Who is in it still, since somebody is heard there, and what ends that.
    pub left: Vec<String>,
}

impl Manager {
    /// No robot is accounted for, and this mediator has a larger epoch.
    fn ask_all(&mut self, epoch: u64, now_ns: u64) {
        self.peers.note_asked(epoch, now_ns);
        self.sessions.epoch = epoch;
        self.effects.entries.push(Entry::Epoch(epoch));
        for robot in 0..self.names.robots().len() {
            self.sessions.unaccount(robot, now_ns);
            self.coordinations.look_again_at(robot);
            self.store_robot(robot);
            self.effects.tell(robot);
        }
    }

    /// Takes in which mediator a robot follows. Returns whether the report is news of a process that may speak for the robot.
    pub(super) fn hear_whom_it_follows(
        &mut self,
        robot: usize,
        report: &RobotReport,
        now_ns: u64,
    ) -> bool {
        let retired = self.sessions.robot(robot).is_retired(report.boot_epoch);
        // Who follows this mediator is heard, whatever somebody has said in its name.
        let of_now = self.peers.is_ours(report) && report.mediator_epoch == self.sessions.epoch;
        let is_next = of_now && self.sessions.robot(robot).is_next(report);
        let elsewhere = retired || report.site != self.names.site;
        if elsewhere || !self.peers.hear(robot, report, is_next, now_ns) {
            return false;
        }
        self.judge_peers(now_ns);
        if self.peers.stands_by {
            return true;
        }
        let sent = self.sessions.robot(robot).sent;
        let larger = self.peers.larger_epoch(report, sent);
        // Once for each time that it is lost: until it has followed this mediator it is not accounted for.
        let is_elsewhere = self.peers.is_foreign(report) || self.peers.is_ahead(report, sent);
        let lost = is_elsewhere && !self.sessions.robot(robot).unaccounted;
        if larger.is_some() || lost || self.peers.asks(robot) {
            if !self.peers.ask(robot, now_ns) {
                // Nothing is granted until it is taken in, and it is not before all were asked.
                if !self.sessions.robot(robot).unaccounted {
                    self.sessions.unaccount(robot, now_ns);
                    self.store_robot(robot);
                }
                return true;
            }
            let epoch = larger.unwrap_or(self.peers.epoch + 1);
            self.effects.alarms.push(Alarm::OlderJournal {
                robot: self.names.robot_id(robot),
                found: report.mediator_epoch,
                epoch,
            });
            self.ask_all(epoch, now_ns);
        }
        true
    }

    /// Decides anew whether to stand by.
    pub(super) fn judge_peers(&mut self, now_ns: u64) {
        let stood_by = self.peers.stands_by;
        if self.peers.decide(now_ns) {
            self.effects.alarms.push(Alarm::SecondMediator {
                instance: self.peers.instance,
                stands_by: self.peers.stands_by,
            });
        }
        if stood_by && !self.peers.stands_by {
            // The other one may have granted anything to anybody.
            let epoch = self.peers.epoch + 1;
            self.effects.alarms.push(Alarm::GoesOn { epoch });
            self.ask_all(epoch, now_ns);
        }
    }

    /// Stops waiting for robots that were said to be absent before this start, and that nobody has heard since. One that was granted
    /// something before, which the journal has lost, enters nothing more by then. One that was heard, though it did not speak for its body
    /// yet, is on the floor: it is waited for, or an operator says again that it is absent.
    pub(super) fn give_up_absent(&mut self, now_ns: u64) {
        if self.peers.stands_by {
            return;
        }
        let absent = |&robot: &usize| {
            let over = now_ns >= self.enters_no_more_ns(robot);
            let session = self.sessions.robot(robot);
            over && session.absent && !session.reports_here
        };
        let absent: Vec<usize> = { self.sessions.awaited().iter().copied() }
            .filter(absent)
            .collect();
        for robot in absent {
            self.effects.alarms.push(Alarm::NotAwaited {
                robot: self.names.robot_id(robot),
            });
            if self.sessions.wait_no_longer_for(robot) {
                self.nobody_is_awaited();
            }
        }
    }

    /// What is free may be granted now, and what robots have may be entered: they hear of it at once.
    pub(super) fn nobody_is_awaited(&mut self) {
        self.areas.touch_all();
        (0..self.names.robots().len()).for_each(|robot| self.effects.tell(robot));
    }

    // ---------------------------------------------------------------- operators

    /// An operator says that no silent robot is in the area, or, where one stands there for all that is known, that it
    /// was `taken_away`. Where somebody is heard in the area that is refused, but for second processes that
    /// were taken away.
    ///
    /// # Errors
    /// [`ClearError`] when there is no such area; a robot that is heard is in it, whichever mediator it follows; one may still
    /// enter it; or one was in it and nobody says that it was taken away.
    pub fn clear(
        &mut self,
        area_id: &str,
        taken_away: bool,
        now_ns: u64,
    ) -> Result<Cleared, ClearError> {
        let area = self.known_area(area_id)?;
        self.takes_orders()?;
        let occupants: Vec<usize> = self.areas.occupants(area).collect();
        let is_heard_there = |robot| {
            let occupant = self.areas.robot(robot);
            let is_there = occupant.has(area) && self.is_heard(robot, now_ns);
            is_there || occupant.seconds.are_heard_in(area, now_ns)
        };
        if let Some(&robot) = { occupants.iter() }.find(|&&robot| is_heard_there(robot)) {
            let cleared = if taken_away {
                self.clear_of_seconds(&occupants, area, now_ns)
            } else {
                Vec::new()
            };
            if !cleared.is_empty() {
                return Ok(Cleared {
                    of: cleared,
                    left: self.left_in(area, now_ns),
                });
            }
            return Err(ClearError::Heard {
                area: area_id.to_owned(),
                robot: self.names.robot_id(robot),
            });
        }
        for &robot in &occupants {
            let (robot_id, occupant) = (self.names.robot_id(robot), self.areas.robot(robot));
            if occupant.holds(area)
                && let Some(wait) = self.may_enter_for(robot, now_ns)
            {
                return Err(ClearError::MayEnter {
                    area: area_id.to_owned(),
                    robot: robot_id,
                    wait,
                });
            }
            if (occupant.stands_in(area) || occupant.seconds.are_in(area)) && !taken_away {
                return Err(ClearError::Inside {
                    area: area_id.to_owned(),
                    robot: robot_id,
                });
            }
        }
        // They go with the robot, and are others.
        let seconds = self.clear_of_seconds(&occupants, area, now_ns);
        let mut of = Vec::new();
        for &robot in &occupants {
            // It may be elsewhere, so whether it is awaited is another matter.
            if self.areas.robot(robot).has(area) {
                of.push(self.names.robot_id(robot));
                self.take_out(robot, area, now_ns);
            }
        }
        of.extend(seconds);
        self.go_on(now_ns);
        let left = Vec::new();
        Ok(Cleared { of, left })
    }

    /// Who is in the area, for an operator who wants it to be empty.
    fn left_in(&self, area: usize, now_ns: u64) -> Vec<String> {
        let (own, seconds) = self.view(now_ns).bodies_in(area);
        let own = own.into_iter().map(|robot| {
            let id = self.names.robot_id(robot);
            if self.is_heard(robot, now_ns) {
                format!("{id} (heard)")
            } else {
                format!("{id} (silent: `mediator absent {id} --taken-away`)")
            }
        });
        let seconds = seconds.into_iter().map(|robot| self.names.robot_id(robot));
        own.chain(seconds.map(|id| format!("{} (heard)", second_of(&id))))
            .collect()
    }

    /// An operator says that a robot is nowhere on the floor: it has no area and asks for none any more, and is not awaited until
    /// it is heard again, also after later starts. Where it stands in some, for all that is known, that it was `taken_away`. Returns the
    /// areas that it has lost.
    ///
    /// # Errors
    /// [`AbsentError`] when there is no such robot, it is heard, it may still enter an area, or stands in one and nobody says that it was
    /// taken away.
    pub fn absent(
        &mut self,
        robot_id: &str,
        taken_away: bool,
        now_ns: u64,
    ) -> Result<Vec<String>, AbsentError> {
        let robot = self.names.robot(robot_id).ok_or_else(|| UnknownRobot {
            found: robot_id.to_owned(),
            known: self.names.all_robots(),
        })?;
        self.takes_orders()?;
        let seconds = &self.areas.robot(robot).seconds;
        let second_in = seconds.areas();
        let mut seconds_heard =
            { second_in.iter() }.map(|&area| seconds.are_heard_in(area, now_ns));
        if self.is_heard(robot, now_ns) || seconds_heard.any(|heard| heard) {
            return Err(AbsentError::Heard(robot_id.to_owned()));
        }
        // As for `clear`: what it has been in it may have left since, and come back to. And what one has that is awaited nobody knows.
        if (self.areas.has_any(robot) || self.sessions.is_awaited(robot))
            && let Some(wait) = self.may_enter_for(robot, now_ns)
        {
            return Err(AbsentError::MayEnter {
                robot: robot_id.to_owned(),
                wait,
            });
        }
        let mut stands_in = self.areas.robot(robot).stands_in.clone();
        stands_in.extend(second_in);
        stands_in.sort_unstable();
        stands_in.dedup();
        if !taken_away && !stands_in.is_empty() {
            return Err(AbsentError::Inside {
                robot: robot_id.to_owned(),
                areas: self.names.area_list(stands_in),
            });
        }
        let areas: Vec<usize> = self.areas.occupied_by(robot).collect();
        for &area in &areas {
            self.take_out(robot, area, now_ns);
        }
        // Also where it had no area.
        self.coordinate(now_ns, |coordinations, around| {
            coordinations.cleared_of(robot, around);
        });
        self.areas.withdraw(robot, &mut self.effects);
        self.effects.tell(robot);
        let was_last = self.sessions.give_up(robot);
        self.coordinations.look_again_at(robot);
        self.store_robot(robot);
        if was_last {
            self.nobody_is_awaited();
        } else {
            self.areas.touch_all();
        }
        self.go_on(now_ns);
        Ok(areas.iter().map(|&area| self.names.area_id(area)).collect())
    }

    /// An operator ends a coordination, named by its id, its number or both, `id/number`. Its robots keep the areas that they
    /// have: where the site says how they get out of the way, they are told to, and a second time they are let go as they are.
    /// Returns its name, and whether they are let go.
    ///
    /// # Errors
    /// [`EndError`] when there is none, or this mediator stands by.
    pub fn end(&mut self, named: &str, now_ns: u64) -> Result<(String, bool), EndError> {
        self.takes_orders()?;
        let mut ended = None;
        self.coordinate(now_ns, |coordinations, around| {
            ended = coordinations.end_by_hand(named, around);
        });
        let ended = ended.ok_or_else(|| NotRunning {
            found: named.to_owned(),
            running: self.coordinations.names_that_run(),
        })?;
        self.go_on(now_ns);
        Ok(ended)
    }

    /// What an operator orders is carried out here, and not by another mediator, which would know nothing of it.
    pub(super) fn takes_orders(&self) -> Result<(), StandsBy> {
        if self.peers.stands_by {
            return Err(StandsBy);
        }
        Ok(())
    }

    /// It reports, whether it follows this mediator or not.
    fn is_heard(&self, robot: usize, now_ns: u64) -> bool {
        self.sessions.is_heard(robot) || self.peers.is_heard(robot, now_ns)
    }

    /// From then on the robot enters no area any more that it has not entered, if it is not heard before.
    pub(super) fn enters_no_more_ns(&self, robot: usize) -> u64 {
        let session = self.sessions.robot(robot);
        let heard_ns = session.heard_ns.max(session.before_until_ns);
        heard_ns.saturating_add(ENTERS_NO_MORE_NS)
    }

    /// For how long it may still enter one, also by a grant of another mediator that it follows.
    fn may_enter_for(&self, robot: usize, now_ns: u64) -> Option<Duration> {
        let heard_ns = self.peers.heard_ns(robot);
        let until_ns =
            { self.enters_no_more_ns(robot) }.max(heard_ns.saturating_add(ENTERS_NO_MORE_NS));
        let left_ns = until_ns.saturating_sub(now_ns);
        (left_ns > 0).then(|| Duration::from_nanos(left_ns))
    }

    fn take_out(&mut self, robot: usize, area: usize, now_ns: u64) {
        self.effects.counters.cleared += 1;
        self.coordinations.look_again_at(robot);
        self.areas.leave(robot, area);
        self.store_robot(robot);
        self.areas.end_hold(robot, area, &mut self.effects);
        self.coordinate(now_ns, |coordinations, around| {
            coordinations.cleared_of(robot, around);
        });
        self.effects.tell(robot);
        self.areas.touch(area);
    }
}
