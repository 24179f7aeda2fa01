//! Asking for grants back that were not used yet, where a coordination needs the area.

use std::collections::BTreeMap;
use std::sync::Arc;

use super::alarm::BadReport;
use super::run::Run;
use super::{Manager, RestoreError};
use crate::journal::{Entry, RevocationRecord, Stored};
use contract::level::{self, PROTOCOL_ID};
use contract::protocols::{self, REVOKE};
use contract::wire::{Access, RobotReport};
use coordination::protocol::{FlagId, MergeError, Party, Protocol, Replica, Side};

/// The revocation protocol with its flag looked up.
#[derive(Clone, Debug)]
pub(super) struct RevocationProtocol {
    protocol: Arc<Protocol>,
    revoke: FlagId,
}

/// Revocations of one robot's grants of one area.
#[derive(Clone, Debug)]
pub(super) struct Revocation {
    replica: Replica,
    /// Of the grant that was last asked back.
    fence: u64,
}

/// By area.
pub(super) type Revocations = BTreeMap<usize, Revocation>;

impl RevocationProtocol {
    pub(super) fn new() -> Self {
        let protocol = protocols::revocation();
        Self {
            revoke: protocol
                .flag(REVOKE)
                .expect("the revocation protocol has its flags"),
            protocol: Arc::new(protocol),
        }
    }

    fn begin(&self) -> Revocation {
        Revocation {
            replica: Replica::new(&self.protocol, PROTOCOL_ID, Party::Second, 0),
            fence: 0,
        }
    }

    fn resume(&self, record: RevocationRecord) -> Result<Revocation, MergeError> {
        Ok(Revocation {
            replica: Replica::resume(&self.protocol, Party::Second, record.level)?,
            fence: record.fence,
        })
    }
}

impl Manager {
    pub(super) fn restore_revocations(&mut self, stored: &Stored) -> Result<(), RestoreError> {
        for ((robot_id, area_id), &record) in &stored.revocations {
            let (robot, area) = (self.known_robot(robot_id)?, self.known_area(area_id)?);
            let revocation =
                { self.revoking.resume(record) }.map_err(|error| RestoreError::Level {
                    robot: robot_id.clone(),
                    area: area_id.clone(),
                    error,
                })?;
            self.robots[robot].revocations.insert(area, revocation);
        }
        Ok(())
    }

    /// Asks for grants back that stand in the way of what coordinations keep for others.
    pub(super) fn revoke_what_is_kept(&mut self) {
        let mut wanted = Vec::new();
        for part in self
            .coordinator
            .instances()
            .flat_map(|instance| &instance.parts)
        {
            let waits = |area: usize| self.robots[part.robot].run(area).is_some_and(Run::waits);
            let open = part
                .kept
                .iter()
                .filter(|kept| !kept.granted && waits(kept.area));
            wanted.extend(open.map(|kept| (kept.area, part.robot)));
        }
        for (area, robot) in wanted {
            let others: Vec<usize> = self.occupants(area).collect();
            if others.len() < self.areas[area].capacity as usize {
                continue;
            }
            let kept = self.coordinator.kept(area);
            for other in others
                .into_iter()
                .filter(|other| *other != robot && !kept.contains(other))
            {
                self.revoke(other, area);
            }
        }
    }

    /// Asks once for a grant back whose robot is not in the area yet.
    fn revoke(&mut self, robot: usize, area: usize) {
        let state = &mut self.robots[robot];
        let stands = state.stands_in.contains(&area);
        let Some(run) =
            { state.runs.get(area) }.filter(|run| run.is_held() && !run.is_entered() && !stands)
        else {
            return;
        };
        let revocation = state.revocations.entry(area);
        let revocation = revocation.or_insert_with(|| self.revoking.begin());
        if revocation.fence == run.fence || revocation.replica.set(self.revoking.revoke).is_err() {
            return;
        }
        revocation.fence = run.fence;
        self.counters.revocations += 1;
        self.store_revocation(robot, area);
        self.tell(robot);
    }

    fn store_revocation(&mut self, robot: usize, area: usize) {
        let Some(revocation) = self.robots[robot].revocations.get(&area) else {
            return;
        };
        self.entries.push(Entry::Revocation {
            robot: self.robots[robot].id.clone(),
            area: self.areas[area].id.clone(),
            record: RevocationRecord {
                level: revocation.replica.level(),
                fence: revocation.fence,
            },
        });
    }

    /// Takes in the answers. What becomes of the area itself, protocol 1 says.
    pub(super) fn merge_revocations(&mut self, robot: usize, report: &RobotReport, first: bool) {
        for access in &report.revocations {
            if let Err(what) = self.merge_revocation(robot, access, first) {
                self.complain(robot, access, what);
            }
        }
    }

    fn merge_revocation(
        &mut self,
        robot: usize,
        access: &Access,
        first: bool,
    ) -> Result<(), BadReport> {
        let level = level::decode(access.level.as_ref())?;
        let Some(&area) = self.area_index.get(&access.area) else {
            return Err(BadReport::UnknownArea);
        };
        let revocation = self.robots[robot].revocations.entry(area);
        let revocation = revocation.or_insert_with(|| self.revoking.begin());
        let mut changed = false;
        match revocation.replica.merge(level) {
            Err(_) if first => {
                changed = true;
                // The journal has lost its last entries: the robot knows better.
                let fence = access.fence;
                *revocation = self.revoking.resume(RevocationRecord { level, fence })?;
            }
            merged => {
                merged?;
            }
        }
        while revocation.replica.poll().is_some() {
            changed = true;
        }
        if changed {
            self.robots[robot].candidate = None;
            self.store_revocation(robot, area);
            self.tell(robot);
        }
        Ok(())
    }

    /// For a message.
    pub(super) fn revocations_of(&self, robot: usize) -> Vec<Access> {
        let all = self.robots[robot].revocations.iter();
        all.filter(|(_, revocation)| revocation.fence > 0)
            .map(|(&area, revocation)| Access {
                area: self.areas[area].id.clone(),
                level: Some(level::encode(revocation.replica.level())),
                fence: revocation.fence,
            })
            .collect()
    }
}
