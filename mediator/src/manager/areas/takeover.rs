//! Robots that have what is not known here, or may have.

use std::collections::BTreeSet;

use contract::wire::{Access, RobotReport};

use super::claim::Claim;
use super::revocation::Revocation;
use super::seconds::{Change, Known, Said, Speaker};
use super::table::Areas;
use crate::journal::Entry;
use crate::manager::alarm::{Alarm, BadReport};
use crate::manager::effects::Effects;

/// What is known of a process that does not speak for its robot, and is heard.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SecondHeard {
    pub(crate) known: Known,
    /// It runs beside the one that speaks for the robot.
    pub(crate) beside: bool,
    /// It has heard what was said after that one was taken in.
    pub(crate) lives: bool,
}

impl Areas {
    /// A robot accounts for itself: what its report says is all that it has, whatever was known of it. Runs may have smaller
    /// numbers than here, where it has restarted with another mediator in between. Returns whether it has other areas than was
    /// known.
    pub(crate) fn take_over(
        &mut self,
        robot: usize,
        report: &RobotReport,
        now_ns: u64,
        effects: &mut Effects,
    ) -> bool {
        let mut surprises = false;
        let claims = std::mem::take(&mut self.robots[robot].claims);
        // A grant that it stands in by may not have reached it: it is found there.
        self.robots[robot].placed = false;
        let mut changed: BTreeSet<usize> = claims.iter().map(|(area, _)| area).collect();
        for &area in &changed {
            self.dequeue(area, robot);
            let none = Claim::new(&self.access);
            self.robots[robot].claims.set(area, none);
        }
        for access in &report.access {
            let run = |area| claims.get(area).map(Claim::run);
            let took = self.level_to_take_over(access, run);
            match took.and_then(|_| self.take_over_claim(robot, access, now_ns)) {
                Ok(area) => drop(changed.insert(area)),
                Err(what) => self.complain(robot, access, what, effects),
            }
        }
        for area in changed {
            let has = |claim: Option<&Claim>| {
                let claim = claim.filter(|claim| claim.is_held());
                claim.map(|claim| (claim.fence, claim.is_entered()))
            };
            let (had, has) = (has(claims.get(area)), has(self.robots[robot].claim(area)));
            // To enter what it was granted is no surprise.
            let known =
                had == has || { had.zip(has) }.is_some_and(|(had, has)| had.0 == has.0 && has.1);
            surprises |= !known;
            if !known && has.is_some() {
                effects.counters.adopted += 1;
                effects.alarms.push(Alarm::TakenOver {
                    robot: self.names.robot_id(robot),
                    area: self.names.area_id(area),
                });
            }
            if let Some((fence, _)) = has
                && fence > self.areas[area].fence
            {
                self.areas[area].fence = fence;
                self.store_fence(area, effects);
            }
            self.concern(area, robot);
            self.unconcern(area, robot);
            self.touch(area);
            self.store_claim(robot, area, effects);
        }
        self.take_over_revocations(robot, report, effects);
        effects.tell(robot);
        surprises
    }

    fn take_over_claim(
        &mut self,
        robot: usize,
        access: &Access,
        now_ns: u64,
    ) -> Result<usize, BadReport> {
        let area = self.resume_claim(robot, access, now_ns)?;
        let claim = self.robots[robot].claims.get_mut(area);
        if let Some(claim) = claim.filter(|claim| !claim.is_requested() && !claim.is_held()) {
            claim.fence = 0;
        }
        Ok(area)
    }

    fn take_over_revocations(&mut self, robot: usize, report: &RobotReport, effects: &mut Effects) {
        let known: Vec<usize> = self.robots[robot].revocations.keys().copied().collect();
        for area in known {
            let none = Revocation::new(&self.revocation);
            self.robots[robot].revocations.insert(area, none);
            self.store_revocation(robot, area, effects);
        }
        for access in &report.revocations {
            if let Err(what) = self.merge_revocation(robot, access, true, effects) {
                self.complain(robot, access, what, effects);
            }
        }
    }

    /// A robot was granted what the journal does not know: others may have been, too, of whom some may not be heard before the
    /// next start.
    pub(super) fn note_unknown_grants(&mut self, area: usize, effects: &mut Effects) {
        if !self.adopted.contains(&area) {
            self.adopted.push(area);
            effects.entries.push(Entry::Adopted {
                area: self.names.area_id(area),
                known: Some(self.areas[area].known_fence),
            });
        }
    }

    /// Every robot has said what it was granted.
    pub(crate) fn all_grants_are_known(&mut self, effects: &mut Effects) {
        for area in self.adopted.drain(..) {
            effects.entries.push(Entry::Adopted {
                area: self.names.area_id(area),
                known: None,
            });
        }
    }

    /// A second process with the robot's name says where it stands: it is another body. Where the robot is known to stand itself, one is
    /// the other's only if it runs `beside` it, and not when it may be its next. Returns whether the journal must know.
    pub(crate) fn hold_for_second(
        &mut self,
        robot: usize,
        report: &RobotReport,
        heard: SecondHeard,
        until_ns: u64,
    ) -> bool {
        let occupant = &mut self.robots[robot];
        let mut areas: Vec<usize> = { report.stands_in.iter() }
            .filter_map(|id| self.names.area(id))
            .collect();
        areas.sort_unstable();
        areas.dedup();
        let (areas, with_robot): (Vec<_>, Vec<_>) = areas.into_iter().partition(|&area| {
            let is_its_own = occupant.seconds.is_in(report.boot_epoch, area);
            heard.beside || is_its_own || !occupant.stands_in(area)
        });
        let said = Said {
            process: report.boot_epoch,
            sequence: report.sequence,
            known: heard.known,
            lives: heard.lives,
            areas: &areas,
            with_robot: &with_robot,
            until_ns,
        };
        let change = if report.located {
            occupant.seconds.take_in(&said)
        } else {
            occupant.seconds.hear(&said, heard.beside)
        };
        for area in change.areas {
            self.concern(area, robot);
            self.unconcern(area, robot);
            self.touch(area);
        }
        change.found
    }

    /// Ends the holds of second processes that were heard too long ago, of those that were not found.
    pub(crate) fn drop_silent_seconds(&mut self, robot: usize, now_ns: u64) -> Change {
        let change = self.robots[robot].seconds.drop_silent(now_ns);
        self.free_of_seconds(robot, &change.areas);
        change
    }

    /// Areas in which a second process that was found has fallen silent now: they stay blocked.
    pub(crate) fn seconds_that_fall_silent(&mut self, robot: usize, now_ns: u64) -> Vec<usize> {
        self.robots[robot].seconds.fall_silent(now_ns)
    }

    /// An operator says that no second process of the robot is in the area which is not heard. Returns whether one was.
    pub(crate) fn clear_of_seconds(&mut self, robot: usize, area: usize, now_ns: u64) -> bool {
        let left = self.robots[robot].seconds.leave_silent(area, now_ns);
        if left {
            self.free_of_seconds(robot, &[area]);
        }
        left
    }

    /// A process speaks for the robot: it is not in its own way, nor, if it is new, for longer than it is heard one before it that was
    /// refused. Where it said that it stands it is, also when it does not know any more. Returns whether the journal must know.
    pub(crate) fn promote_second(
        &mut self,
        robot: usize,
        report: &RobotReport,
        is_new: bool,
    ) -> bool {
        let seconds = &mut self.robots[robot].seconds;
        // It was about to be followed by a new one, and is heard again: what it had it has.
        let goes_on = seconds.is_before(report.boot_epoch);
        let (own, appear) = seconds.promote(report.boot_epoch, is_new);
        if !report.located && !goes_on {
            self.suspect_in(robot, own.iter().copied());
        }
        self.free_of_seconds(robot, &own);
        self.free_of_seconds(robot, &appear);
        goes_on || !own.is_empty() || !appear.is_empty()
    }

    pub(super) fn free_of_seconds(&mut self, robot: usize, areas: &[usize]) {
        for &area in areas {
            self.unconcern(area, robot);
            self.touch(area);
        }
    }

    /// A process that does not speak for the robot yet, as the `speaker` does that was heard last, says where it stands: it may be there, and
    /// also where it was. Returns whether that is new.
    pub(crate) fn suspect(
        &mut self,
        robot: usize,
        report: &RobotReport,
        speaker: Option<Speaker>,
    ) -> bool {
        if !report.located {
            return false;
        }
        let areas = { report.stands_in.iter() }.filter_map(|id| self.names.area(id));
        let areas: Vec<usize> = areas.collect();
        if { areas.iter() }.all(|&area| self.robots[robot].stands_in(area)) {
            return false;
        }
        // Where that one was cannot be told from where this one says that it is any more.
        self.note_before(robot, speaker);
        self.suspect_in(robot, areas)
    }

    fn suspect_in(&mut self, robot: usize, areas: impl IntoIterator<Item = usize>) -> bool {
        let mut news = false;
        for area in areas {
            let occupant = &mut self.robots[robot];
            if occupant.stands_in(area) {
                continue;
            }
            occupant.stands_in.push(area);
            occupant.stands_in.sort_unstable();
            // It has not said so as the one that speaks for the robot, so nobody is accused.
            occupant.placed = false;
            self.concern(area, robot);
            self.touch(area);
            news = true;
        }
        news
    }
}
