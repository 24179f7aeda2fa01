//! What robots report of areas: their flags of protocol 1, and where they stand.

use contract::wire::{Access, RobotReport};

use super::claim::{Claim, Deed};
use super::reservations::Reservations;
use super::table::Areas;
use crate::journal::AccessRecord;
use crate::manager::alarm::{Alarm, BadReport};
use crate::manager::effects::Effects;
use crate::manager::sessions::Heard;
use crate::nets::GivenBack;

impl Areas {
    /// Takes in everything that a report says of protocol 1 and of revocations. Returns whether a level has changed.
    pub(crate) fn take_in(
        &mut self,
        robot: usize,
        report: &RobotReport,
        heard: Heard,
        now_ns: u64,
        reservations: &mut dyn Reservations,
        effects: &mut Effects,
    ) -> bool {
        // Nothing was granted since the start.
        let first = heard.first && heard.awaited;
        let mut changed = false;
        for access in &report.access {
            let merged = match self.merge(robot, access, now_ns, reservations, effects) {
                Err(BadReport::Merge(_)) if first => self.adopt(robot, access, now_ns, effects),
                merged => merged,
            };
            match merged {
                Ok(news) => changed |= news,
                Err(what) => {
                    let unknown = heard.first && matches!(what, BadReport::Merge(_));
                    if !unknown {
                        self.complain(robot, access, what, effects);
                    }
                    if let Some(area) = self.void(robot, access, effects)
                        && unknown
                    {
                        effects.alarms.push(Alarm::Void {
                            robot: self.names.robot_id(robot),
                            area: self.names.area_id(area),
                        });
                    }
                }
            }
        }
        for access in &report.revocations {
            match self.merge_revocation(robot, access, first, effects) {
                Ok(news) => changed |= news,
                Err(what) => self.complain(robot, access, what, effects),
            }
        }
        changed
    }

    fn merge(
        &mut self,
        robot: usize,
        access: &Access,
        now_ns: u64,
        reservations: &mut dyn Reservations,
        effects: &mut Effects,
    ) -> Result<bool, BadReport> {
        let (level, area) = self.level_and_area(access)?;
        let protocol = &self.access;
        let claims = &mut self.robots[robot].claims;
        let claim = claims.get_or_insert_with(area, || Claim::new(protocol));
        if claim.is_of_other_grant(level, access.fence) {
            effects.counters.other_fence += 1;
            let (found, expected) = (access.fence, claim.fence);
            return Err(BadReport::Fence { found, expected });
        }
        let before = (claim.fence, claim.doubtful);
        let news = claim.merge(level)?;
        claim.complained = false;
        if !news {
            return Ok(false);
        }
        let mut changed = false;
        while let Some(claim) = self.robots[robot].claims.get_mut(area)
            && let Some(deed) = claim.next_deed(&self.access)
        {
            changed = true;
            match deed {
                Deed::Requested => {
                    Self::draw_ticket(&mut self.ticket, claim, now_ns);
                    claim.why.0 = 0;
                    effects.counters.requests += 1;
                    self.enqueue(area, robot);
                }
                Deed::Entered => self.concern(area, robot),
                Deed::GaveBack { entered } => {
                    if entered {
                        self.robots[robot].left.push(area);
                    }
                    effects.counters.given_back += 1;
                    let how = self.given_back(robot, area, entered.then_some(before));
                    reservations.gave_back(robot, area, how, effects);
                    self.unconcern(area, robot);
                    self.touch(area);
                }
            }
        }
        if changed {
            self.store_claim(robot, area, effects);
            effects.tell(robot);
        }
        Ok(changed)
    }

    /// How a robot has given an area back that it has entered by the grant of this fence, if it has; that may be doubtful, or the
    /// mediator may have asked for it.
    fn given_back(&self, robot: usize, area: usize, entered: Option<(u64, bool)>) -> GivenBack {
        let revocation = self.robots[robot].revocations.get(&area);
        let asks = |fence| revocation.is_some_and(|own| own.asks_for(fence));
        match entered {
            None => GivenBack::Unused,
            Some((fence, doubtful)) if doubtful || asks(fence) => GivenBack::Taken,
            Some(_) => GivenBack::Used,
        }
    }

    /// The claim that a robot says it has replaces the one that is known; it queues up again if it asks. Returns the area.
    pub(super) fn resume_claim(
        &mut self,
        robot: usize,
        access: &Access,
        now_ns: u64,
    ) -> Result<usize, BadReport> {
        let (level, area) = self.level_and_area(access)?;
        let record = AccessRecord::said(level, access.fence);
        let mut claim = Claim::resume(&self.access, record)?;
        self.dequeue(area, robot);
        let asks = claim.is_requested();
        if asks {
            Self::draw_ticket(&mut self.ticket, &mut claim, now_ns);
        }
        self.robots[robot].claims.set(area, claim);
        if asks {
            self.enqueue(area, robot);
        }
        Ok(area)
    }

    /// After a power loss the journal may lack the last grants. Until every robot has reported nothing is granted, so what a
    /// robot has on its first report since the start was given to it before.
    fn adopt(
        &mut self,
        robot: usize,
        access: &Access,
        now_ns: u64,
        effects: &mut Effects,
    ) -> Result<bool, BadReport> {
        let run = |area| self.robots[robot].claim(area).map(Claim::run);
        let (level, area) = self.level_to_take_over(access, run)?;
        let claim = self.robots[robot].claim(area);
        if !claim.is_none_or(|claim| claim.is_behind(level)) {
            return Ok(false);
        }
        let (found, after) = (access.fence, self.areas[area].known_fence);
        let held = Claim::resume(&self.access, AccessRecord::said(level, found))?.is_held();
        if held && found <= after {
            // The journal knows to whom that fence was given, if to anybody.
            return Err(BadReport::NoGrant { found, after });
        }
        self.resume_claim(robot, access, now_ns)?;
        effects.counters.adopted += 1;
        effects.alarms.push(Alarm::Adopted {
            robot: self.names.robot_id(robot),
            area: self.names.area_id(area),
        });
        if access.fence > self.areas[area].fence {
            self.areas[area].fence = access.fence;
            self.store_fence(area, effects);
            self.note_unknown_grants(area, effects);
        }
        self.concern(area, robot);
        self.touch(area);
        self.store_claim(robot, area, effects);
        effects.tell(robot);
        Ok(false)
    }

    /// The robot says that it has more than is known here, which is not believed: another robot may have been granted the area
    /// since. It hears that this has ended, before or with the news that it was heard, by which it might enter. Returns the area,
    /// if it has none here by a grant.
    fn void(&mut self, robot: usize, access: &Access, effects: &mut Effects) -> Option<usize> {
        let run = |area| self.robots[robot].claim(area).map(Claim::run);
        let (level, area) = self.level_to_take_over(access, run).ok()?;
        let claim = self.robots[robot].claim(area);
        if claim.is_some_and(|claim| claim.is_held() || !claim.is_behind(level)) {
            return None;
        }
        let mut claim = Claim::resume(&self.access, AccessRecord::said(level, 0)).ok()?;
        claim.abort();
        claim.complained = true;
        self.dequeue(area, robot);
        self.robots[robot].claims.set(area, claim);
        self.unconcern(area, robot);
        self.touch(area);
        self.store_claim(robot, area, effects);
        effects.tell(robot);
        Some(area)
    }

    /// Raises the alarm, once for each level that makes no sense.
    pub(super) fn complain(
        &mut self,
        robot: usize,
        access: &Access,
        what: BadReport,
        effects: &mut Effects,
    ) {
        effects.counters.bad += 1;
        if let Some(area) = self.names.area(&access.area)
            && let Some(claim) = self.robots[robot].claims.get_mut(area)
            && std::mem::replace(&mut claim.complained, true)
        {
            return;
        }
        self.complain_of_area(robot, &access.area, what, effects);
    }

    fn complain_of_area(&self, robot: usize, area: &str, what: BadReport, effects: &mut Effects) {
        effects.alarms.push(Alarm::BadReport {
            robot: self.names.robot_id(robot),
            area: area.to_owned(),
            what,
        });
    }

    // ---------------------------------------------------------------- where it stands

    /// Takes over where the robot stands, and notices where it should not. Returns whether the journal must know.
    pub(crate) fn place(
        &mut self,
        robot: usize,
        report: &RobotReport,
        effects: &mut Effects,
    ) -> bool {
        let relocated = self.robots[robot].located != report.located;
        self.robots[robot].located = report.located;
        if relocated {
            self.touch_what_waits(robot);
        }
        let mut stands_in: Vec<usize> = Vec::with_capacity(report.stands_in.len());
        for id in &report.stands_in {
            match self.names.area(id) {
                Some(area) => stands_in.push(area),
                None => {
                    effects.counters.bad += 1;
                    self.complain_of_area(robot, id, BadReport::UnknownArea, effects);
                }
            }
        }
        let occupant = &mut self.robots[robot];
        let left = std::mem::take(&mut occupant.left);
        if !report.located {
            occupant.doubt();
            // Where it says it stands may be wrong: it may still be where it was, but for what it had left before.
            let was_in = { occupant.stands_in.iter() }.filter(|area| !left.contains(area));
            stands_in.extend(was_in);
        }
        stands_in.sort_unstable();
        stands_in.dedup();
        let mut new_state = false;
        let mut first = false;
        if report.located {
            // Before that, a robot that has restarted does not know where it was and in which state: we do.
            first = !std::mem::replace(&mut occupant.placed, true);
            occupant.is_known = true;
            occupant.pose = report.pose;
            new_state = occupant.fsm_state != report.fsm_state;
            if new_state {
                occupant.fsm_state.clone_from(&report.fsm_state);
            }
        }
        let before = std::mem::replace(&mut occupant.stands_in, stands_in.clone());
        if first {
            let mut found_in = stands_in.clone();
            found_in.retain(|&area| !occupant.holds(area));
            occupant.found_in = found_in;
            // What it has entered and is not in by this may be asked back now.
            let entered = { occupant.claims.iter() }.filter(|(_, claim)| claim.is_entered());
            for area in entered.map(|(area, _)| area).collect::<Vec<usize>>() {
                self.touch(area);
            }
        } else {
            occupant.found_in.retain(|area| stands_in.contains(area));
        }
        let mut others = false;
        for &area in before.iter().filter(|area| !stands_in.contains(area)) {
            others |= self.robots[robot].seconds.robot_leaves(area);
            self.unconcern(area, robot);
            self.touch(area);
        }
        for &area in stands_in.iter().filter(|area| !before.contains(area)) {
            self.concern(area, robot);
            self.touch(area);
        }
        self.judge_intrusion(robot, effects);
        before != stands_in || new_state || others
    }

    fn judge_intrusion(&mut self, robot: usize, effects: &mut Effects) {
        let occupant = &mut self.robots[robot];
        let intrudes_in: Vec<usize> = { occupant.stands_in.iter().copied() }
            .filter(|&area| occupant.intrudes(area))
            .collect();
        let before = std::mem::replace(&mut occupant.intrudes_in, intrudes_in.clone());
        for area in intrudes_in {
            if !before.contains(&area) {
                self.touch(area);
                effects.alarms.push(Alarm::Intruder {
                    robot: self.names.robot_id(robot),
                    area: self.names.area_id(area),
                });
            }
        }
    }
}
