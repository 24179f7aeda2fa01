//! Asking for grants back that are not in use: where a coordination needs the area, robots wait for each other, or somebody is in it who
//! should not be.

use contract::level;
use contract::wire::Access;

use super::reservations::{Reservations, Reserved};
use super::revocation::Revocation;
use super::table::Areas;
use crate::journal::Entry;
use crate::manager::alarm::BadReport;
use crate::manager::effects::Effects;
use crate::manager::sessions::Sessions;

/// Whose grants are asked back.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Whose {
    /// Of robots that have not been in the area yet. What a net has let one into, it may go through to the end.
    NotEntered,
    /// Also of those that have left it.
    NotThere,
}

impl Areas {
    /// Asks for grants back that stand in the way of what coordinations keep for others that can use it.
    pub(super) fn revoke_what_is_kept(
        &mut self,
        sessions: &Sessions,
        reservations: &dyn Reservations,
        effects: &mut Effects,
    ) {
        for Reserved { area, robot } in reservations.open() {
            let others: Vec<usize> = self.occupants(area).collect();
            if !self.robots[robot].waits_for(area)
                || !self.can_use_grants(robot, sessions)
                || others.len() < self.areas[area].capacity as usize
            {
                continue;
            }
            let kept = reservations.kept(area);
            for other in others {
                if other != robot && !kept.contains(&other) {
                    self.revoke(other, area, Whose::NotEntered, effects);
                }
            }
        }
    }

    /// Asks for all grants of an area back whose robots have not been in it yet.
    pub(crate) fn revoke_what_is_not_used(&mut self, area: usize, effects: &mut Effects) {
        for robot in self.occupants(area).collect::<Vec<usize>>() {
            self.revoke(robot, area, Whose::NotEntered, effects);
        }
    }

    /// The same of those that have left it, and keep it to come back: they would meet whoever is there.
    pub(super) fn keep_out(&mut self, area: usize, effects: &mut Effects) {
        for robot in self.occupants(area).collect::<Vec<usize>>() {
            self.revoke(robot, area, Whose::NotThere, effects);
        }
    }

    /// Asks for one back, if its robot has not been in the area yet.
    pub(crate) fn revoke_if_not_used(&mut self, robot: usize, area: usize, effects: &mut Effects) {
        self.revoke(robot, area, Whose::NotEntered, effects);
    }

    /// Robots that have kept a grant because they could not stop before the area, and are not in it a while later, can stop by now:
    /// they are asked again, as long as there is a reason to.
    pub(crate) fn ask_again(&mut self, now_ns: u64) {
        for robot in 0..self.robots.len() {
            let occupant = &mut self.robots[robot];
            let old = { occupant.revocations.iter_mut() }
                .filter_map(|(&area, own)| own.grows_old(now_ns).then_some(area));
            for area in old.collect::<Vec<usize>>() {
                self.touch(area);
            }
        }
    }

    /// Asks for a grant back.
    fn revoke(&mut self, robot: usize, area: usize, whose: Whose, effects: &mut Effects) {
        let occupant = &mut self.robots[robot];
        // Until it has said where it stands, one that has entered may be there.
        let is_there = |entered| match whose {
            Whose::NotEntered => entered,
            Whose::NotThere => entered && !occupant.placed,
        };
        let claim = { occupant.claims.get(area) }
            .filter(|claim| claim.is_held() && !is_there(claim.is_entered()))
            .filter(|_| !occupant.stands_in(area));
        let Some(fence) = claim.map(|claim| claim.fence) else {
            return;
        };
        let protocol = &self.revocation;
        let revocation =
            { occupant.revocations.entry(area) }.or_insert_with(|| Revocation::new(protocol));
        if !revocation.ask(protocol, fence) {
            return;
        }
        effects.counters.revocations += 1;
        self.store_revocation(robot, area, effects);
        effects.tell(robot);
    }

    pub(super) fn store_revocation(&self, robot: usize, area: usize, effects: &mut Effects) {
        if let Some(revocation) = self.robots[robot].revocations.get(&area) {
            effects.entries.push(Entry::Revocation {
                robot: self.names.robot_id(robot),
                area: self.names.area_id(area),
                record: revocation.record(),
            });
        }
    }

    /// Takes in an answer. What becomes of the area itself, protocol 1 says. Returns whether there was something new.
    pub(super) fn merge_revocation(
        &mut self,
        robot: usize,
        access: &Access,
        first: bool,
        effects: &mut Effects,
    ) -> Result<bool, BadReport> {
        let run = |area| {
            self.robots[robot]
                .revocations
                .get(&area)
                .map(Revocation::run)
        };
        let (level, area) = self.level_to_take_over(access, run)?;
        let protocol = &self.revocation;
        let revocation = { self.robots[robot].revocations.entry(area) }
            .or_insert_with(|| Revocation::new(protocol));
        let changed = revocation.merge(protocol, level, access.fence, first)?;
        if changed {
            self.store_revocation(robot, area, effects);
            // What it was asked for in another run it is asked for again.
            self.touch(area);
            effects.tell(robot);
        }
        Ok(changed)
    }

    /// For a message; `known`: the robot has heard that one, if any that counts.
    pub(crate) fn revocations_of(&self, robot: usize, known: Option<u64>) -> Vec<Access> {
        let all = self.robots[robot].revocations.iter();
        all.filter(|(_, revocation)| revocation.is_said(known))
            .map(|(&area, revocation)| (area, revocation.record()))
            .map(|(area, record)| Access {
                area: self.names.area_id(area),
                level: Some(level::encode(record.level)),
                fence: record.fence,
            })
            .collect()
    }

    /// A message of this number says how everything stands that the robot does not know.
    pub(crate) fn note_said(&mut self, robot: usize, number: u64) {
        let occupant = &mut self.robots[robot];
        occupant
            .claims
            .iter_mut()
            .for_each(|claim| claim.note(number));
        { occupant.revocations.values_mut() }.for_each(|revocation| revocation.note(number));
    }
}
