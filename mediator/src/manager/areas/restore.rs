//! Areas from the site file and the journal.

use std::collections::BTreeSet;

use contract::timing::ENTERS_NO_MORE_NS;
use coordination::protocol::MergeError;

use super::claim::Claim;
use super::revocation::Revocation;
use super::seconds::Found;
use super::table::Areas;
use crate::journal::{SecondRecord, Stored};
use crate::manager::error::RestoreError;
use crate::manager::names::Names;
use crate::setup::Setup;

impl Areas {
    /// Takes up where the journal ends. A robot that was never heard of stands where the site file lets it start.
    pub(crate) fn restore(
        setup: &Setup,
        names: &std::sync::Arc<Names>,
        stored: &Stored,
        now_ns: u64,
    ) -> Result<Self, RestoreError> {
        let mut areas = Self::new(setup, names);
        areas.place_unheard(setup, stored);
        for (id, &fence) in &stored.fences {
            let area = known_area(names, id)?;
            areas.areas[area].fence = fence;
            areas.areas[area].known_fence = fence;
        }
        for (id, &known) in &stored.adopted {
            let area = known_area(names, id)?;
            areas.areas[area].known_fence = known;
            areas.adopted.push(area);
        }
        for (id, record) in &stored.closed {
            let area = known_area(names, id)?;
            areas.areas[area].closed = Some(record.clone());
        }
        let gone = gone_for_good(&areas, stored);
        for (id, record) in &stored.robots {
            if gone.contains(id.as_str()) {
                continue;
            }
            let robot = known_robot(names, id)?;
            let mut stands_in = Vec::with_capacity(record.stands_in.len());
            for id in &record.stands_in {
                let area = known_area(names, id)?;
                stands_in.push(area);
                areas.concern(area, robot);
            }
            areas.robots[robot].stands_in = stands_in;
            areas.robots[robot].is_known = record.session > 0;
            for second in &record.seconds {
                let known = |ids: &[String]| -> Result<Vec<usize>, RestoreError> {
                    ids.iter().map(|id| known_area(names, id)).collect()
                };
                let found = Found {
                    process: second.boot_epoch,
                    sequence: second.sequence,
                    alone: second.alone && !record.found.contains(&second.boot_epoch),
                    areas: known(&second.stands_in)?,
                    with_robot: known(&second.with_robot)?,
                    before: second.before,
                };
                for &area in &found.areas {
                    areas.concern(area, robot);
                }
                // As long as the process has that speaks for the robot.
                let until_ns = now_ns.saturating_add(ENTERS_NO_MORE_NS);
                areas.robots[robot].seconds.restore(found, until_ns);
            }
            areas.robots[robot].fsm_state.clone_from(&record.fsm_state);
        }
        areas.restore_claims(stored, &gone, now_ns)?;
        areas.restore_revocations(stored, &gone)?;
        Ok(areas)
    }

    fn place_unheard(&mut self, setup: &Setup, stored: &Stored) {
        let known = |id: &str| stored.robots.contains_key(id);
        let unheard = setup
            .robots
            .iter()
            .enumerate()
            .filter(|(_, own)| !known(&own.id));
        for (robot, own) in unheard {
            let mut stands_in: Vec<usize> = { own.starts_in.iter() }
                .filter_map(|id| self.names.area(id))
                .collect();
            stands_in.sort_unstable();
            stands_in.iter().for_each(|&area| self.concern(area, robot));
            self.robots[robot].stands_in = stands_in;
        }
    }

    fn restore_claims(
        &mut self,
        stored: &Stored,
        gone: &BTreeSet<&str>,
        now_ns: u64,
    ) -> Result<(), RestoreError> {
        for ((robot_id, area_id), &record) in &stored.access {
            if gone.contains(robot_id.as_str()) {
                continue;
            }
            let (robot, area) = known_pair(&self.names, robot_id, area_id)?;
            let mut claim = Claim::resume(&self.access, record)
                .map_err(|error| no_level(robot_id, area_id, "access", error))?;
            claim.asked_ns = now_ns;
            self.ticket = self.ticket.max(claim.ticket);
            let waits = claim.waits();
            let matters = waits || claim.is_held();
            self.robots[robot].claims.set(area, claim);
            if matters {
                self.concern(area, robot);
            }
            if waits {
                self.enqueue(area, robot);
            }
        }
        Ok(())
    }

    fn restore_revocations(
        &mut self,
        stored: &Stored,
        gone: &BTreeSet<&str>,
    ) -> Result<(), RestoreError> {
        for ((robot_id, area_id), &record) in &stored.revocations {
            if gone.contains(robot_id.as_str()) {
                continue;
            }
            let (robot, area) = known_pair(&self.names, robot_id, area_id)?;
            let revocation = Revocation::resume(&self.revocation, record)
                .map_err(|error| no_level(robot_id, area_id, "revocation", error))?;
            self.robots[robot].revocations.insert(area, revocation);
        }
        Ok(())
    }
}

/// Robots that the site does not list any more, and that are nowhere: they were awaited and never came, or were said to be absent.
fn gone_for_good<'a>(areas: &Areas, stored: &'a Stored) -> BTreeSet<&'a str> {
    let has = |id: &str| {
        let mut claims = { stored.access.iter() }.filter(|((robot, _), _)| robot == id);
        claims.any(|(_, &record)| {
            Claim::resume(&areas.access, record).is_ok_and(|claim| claim.is_held())
        })
    };
    let robots = { stored.robots.iter() }.filter(|(id, record)| {
        let is_somewhere = |second: &SecondRecord| !second.stands_in.is_empty();
        let other = record.seconds.iter().any(is_somewhere);
        let nowhere = record.absent && record.stands_in.is_empty() && !has(id);
        areas.names.robot(id).is_none() && !other && (record.session == 0 || nowhere)
    });
    robots.map(|(id, _)| id.as_str()).collect()
}

fn no_level(robot: &str, area: &str, protocol: &'static str, error: MergeError) -> RestoreError {
    RestoreError::Level {
        robot: robot.to_owned(),
        area: area.to_owned(),
        protocol,
        error,
    }
}

fn known_area(names: &Names, id: &str) -> Result<usize, RestoreError> {
    names.area(id).ok_or_else(|| RestoreError::Unknown {
        kind: "area",
        id: id.to_owned(),
    })
}

fn known_robot(names: &Names, id: &str) -> Result<usize, RestoreError> {
    names.robot(id).ok_or_else(|| RestoreError::Unknown {
        kind: "robot",
        id: id.to_owned(),
    })
}

fn known_pair(names: &Names, robot: &str, area: &str) -> Result<(usize, usize), RestoreError> {
    Ok((known_robot(names, robot)?, known_area(names, area)?))
}
