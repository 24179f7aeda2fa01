//! Protocol 1 of every area, from the robot's side.

use std::collections::BTreeMap;

use coordination::protocol::{Change, Level, MergeError, Merged, Position, Replica, Side};

use super::situation::{ClientCounters, Situation};
use crate::level::{self, LevelError};
use crate::mention::Mention;
use crate::protocols::{AccessProtocol, ControlError, ROBOT_PARTY, begin};
use crate::wire::{Access, AccessGrant};

/// The robot's claim on one area: the run of protocol 1 under way, and those before it.
#[derive(Clone, Debug)]
struct Claim {
    replica: Replica,
    /// Of the grant of this run, 0 before there is one.
    fence: u64,
    /// Why it waits, as the mediator says.
    waits_for: String,
    /// From before a restart, or before the robot knew where it is, and not yet confirmed by where it stands.
    doubtful: bool,
    mention: Mention,
}

impl Claim {
    fn new(replica: Replica) -> Self {
        Self {
            replica,
            fence: 0,
            waits_for: String::new(),
            doubtful: false,
            mention: Mention::default(),
        }
    }

    /// It has done no more than ask, or what it had is over.
    fn is_unbound(&self, protocol: &AccessProtocol) -> bool {
        let at = self.replica.position();
        at == Position::START || at == protocol.requested_at || protocol.protocol.is_end(at)
    }

    /// The level is the mediator's word for where this robot is; what it has by that it has not seen granted.
    fn take_over(&mut self, protocol: &AccessProtocol, level: Level) -> Result<(), MergeError> {
        self.replica = Replica::resume(&protocol.protocol, ROBOT_PARTY, level)?;
        self.doubtful = protocol.is_held(self.replica.position());
        Ok(())
    }

    /// It was used, and is not now.
    fn rests(&self) -> bool {
        self.replica.position() == Position::START
    }
}

/// Why what the mediator says of a protocol was ignored.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub(super) enum BadLevel {
    #[error(transparent)]
    Protocol(#[from] ControlError),
    #[error(transparent)]
    Level(#[from] LevelError),
    #[error(transparent)]
    Merge(#[from] MergeError),
}

/// The robot's claims, by area.
#[derive(Clone, Debug)]
pub(super) struct Claims {
    protocol: AccessProtocol,
    by_area: BTreeMap<String, Claim>,
}

impl Claims {
    pub(super) fn new() -> Self {
        Self {
            protocol: AccessProtocol::new(),
            by_area: BTreeMap::new(),
        }
    }

    pub(super) fn forget(&mut self) {
        self.by_area.clear();
    }

    /// Takes over where the mediator left the robot before its restart.
    pub(super) fn inherit(&mut self, grant: &AccessGrant) -> Result<(), BadLevel> {
        let level = level::decode(grant.level.as_ref())?;
        let mut claim = Claim::new(begin(&self.protocol.protocol, ROBOT_PARTY));
        claim.take_over(&self.protocol, level)?;
        claim.fence = grant.fence;
        claim.waits_for.clone_from(&grant.waits_for);
        self.by_area.insert(grant.area.clone(), claim);
        Ok(())
    }

    /// Whether one of these levels cannot follow what this process has said.
    pub(super) fn contradict(&self, grants: &[AccessGrant]) -> bool {
        grants.iter().any(|grant| {
            let claim = self.by_area.get(&grant.area).cloned();
            let mut claim =
                claim.unwrap_or_else(|| Claim::new(begin(&self.protocol.protocol, ROBOT_PARTY)));
            level::decode(grant.level.as_ref()).is_ok_and(|level| {
                let is_unbound = claim.is_unbound(&self.protocol);
                let follows =
                    |error: &MergeError| is_ahead(error) && level.progress == 0 && is_unbound;
                let merged = claim.replica.merge(level);
                merged.is_err_and(|error| !follows(&error))
            })
        })
    }

    /// Takes in a level.
    pub(super) fn learn(
        &mut self,
        grant: &AccessGrant,
        counters: &mut ClientCounters,
    ) -> Result<(), BadLevel> {
        let level = level::decode(grant.level.as_ref())?;
        let protocol = &self.protocol;
        let claim = { self.by_area.entry(grant.area.clone()) }
            .or_insert_with(|| Claim::new(begin(&protocol.protocol, ROBOT_PARTY)));
        if level.run < claim.replica.run() {
            claim.mention.renew();
        }
        let merged = match claim.replica.merge(level) {
            // This process has forgotten what the mediator therefore leaves out.
            Err(error) if is_ahead(&error) && claim.is_unbound(protocol) => {
                claim.take_over(protocol, level)?;
                Merged::Risen
            }
            merged => merged?,
        };
        claim.waits_for.clone_from(&grant.waits_for);
        if merged == Merged::Nothing {
            // Its fence may be that of a mediator which has forgotten the grant.
            return Ok(());
        }
        claim.mention.renew();
        while let Some(change) = claim.replica.poll() {
            match change {
                Change::Flag(flag) if flag == protocol.granted => counters.grants += 1,
                Change::Flag(_) => {}
                Change::Aborted => counters.aborted += 1,
            }
        }
        let held = protocol.is_held(claim.replica.position());
        claim.fence = if held { grant.fence } else { 0 };
        Ok(())
    }

    fn is_held(&self, claim: &Claim) -> bool {
        self.protocol.is_held(claim.replica.position())
    }

    pub(super) fn holds(&self, area: &str) -> bool {
        let claim = self.by_area.get(area);
        claim.is_some_and(|claim| self.is_held(claim) && !claim.doubtful)
    }

    pub(super) fn may_hold(&self, area: &str) -> bool {
        let claim = self.by_area.get(area);
        claim.is_some_and(|claim| self.is_held(claim))
    }

    pub(super) fn is_entered(&self, area: &str) -> bool {
        let claim = self.by_area.get(area);
        claim.is_some_and(|claim| claim.replica.position() == self.protocol.entered_at)
    }

    /// Areas that the robot waits for, each with the reason.
    pub(super) fn waiting(&self) -> impl Iterator<Item = (&str, &str)> {
        { self.by_area.iter() }
            .filter(|(_, claim)| {
                claim.replica.position() != Position::START && !self.is_held(claim)
            })
            .map(|(area, claim)| (area.as_str(), claim.waits_for.as_str()))
    }

    /// The mediator wants this grant back. Returns whether the robot has it no more: not if it needs the area. One that has left it, and
    /// has kept it since it would come back, releases it.
    pub(super) fn give_back(&mut self, area: &str, fence: u64, needed: bool) -> bool {
        let protocol = &self.protocol;
        let claim = self
            .by_area
            .get_mut(area)
            .filter(|claim| protocol.is_held(claim.replica.position()) && claim.fence == fence);
        match claim {
            // It was given back before, because of the same revocation.
            None => true,
            Some(_) if needed => false,
            Some(claim) => {
                let has_entered = claim.replica.position() == protocol.entered_at;
                let flag = if has_entered {
                    protocol.released
                } else {
                    protocol.returned
                };
                claim.replica.set(flag).is_ok()
            }
        }
    }

    /// Where the robot was so far may be wrong: also what it has asked for it may be granted because it was thought to stand there.
    pub(super) fn doubt(&mut self) {
        let protocol = &self.protocol.protocol;
        for claim in self.by_area.values_mut() {
            let at = claim.replica.position();
            claim.doubtful = at != Position::START && !protocol.is_end(at);
        }
    }

    /// Sets `entered`, `released` and `returned` by where the robot stands and what it wants. Returns whether one was set.
    pub(super) fn follow(&mut self, situation: &Situation, wanted: &[&str]) -> bool {
        let protocol = &self.protocol;
        let mut news = false;
        for (area, claim) in &mut self.by_area {
            let stands = situation.stands_in.contains(area);
            let at = claim.replica.position();
            // What it was granted before it restarted, and is surely not in, it gives back: the mediator may have lost more. And so
            // what it has by another pose, or is granted because it asked by that.
            let wants = if protocol.is_held(at) && std::mem::take(&mut claim.doubtful) {
                situation.committed.contains(area)
            } else {
                wanted.contains(&area.as_str())
            };
            let flag = if at == protocol.granted_at && stands {
                Some(protocol.entered)
            } else if at == protocol.granted_at && !wants {
                Some(protocol.returned)
            } else if at == protocol.entered_at && !stands && !wants {
                Some(protocol.released)
            } else {
                None
            };
            // Also what it gives back names the grant, until the mediator has emptied the array.
            news |= flag.is_some_and(|flag| claim.replica.set(flag).is_ok());
        }
        news
    }

    /// Asks for what is wanted and was not asked for. Returns whether there was such an area.
    pub(super) fn request(&mut self, wanted: &[&str]) -> bool {
        let protocol = &self.protocol;
        let mut news = false;
        for &area in wanted {
            let asked = |claim: &Claim| claim.replica.position() != Position::START;
            if !self.by_area.get(area).is_some_and(asked) {
                let claim = { self.by_area.entry(area.to_owned()) }
                    .or_insert_with(|| Claim::new(begin(&protocol.protocol, ROBOT_PARTY)));
                news |= claim.replica.set(protocol.request).is_ok();
            }
        }
        news
    }

    /// For the report of this number. `known`: the mediator has heard that one, and what rested in it.
    pub(super) fn report(&mut self, number: u64, known: Option<u64>) -> Vec<Access> {
        let said = |(area, claim): (&String, &mut Claim)| {
            let left_out = claim.rests() && is_known(&claim.mention, known);
            claim.mention.note(number);
            let report = report_of(area, &claim.replica, claim.fence);
            report.filter(|_| !left_out)
        };
        self.by_area.iter_mut().filter_map(said).collect()
    }
}

/// The other side is in a later run, which this one does not know to have begun.
pub(super) fn is_ahead(error: &MergeError) -> bool {
    matches!(error, MergeError::UnexpectedRun { present, found } if found > present)
}

/// Whether the other side knows the level; `heard`: it has heard that message, if any that counts.
pub(super) fn is_known(mention: &Mention, heard: Option<u64>) -> bool {
    heard.is_some_and(|heard| mention.is_known(heard))
}

/// What a report says of a protocol about an area, if that was ever used.
pub(super) fn report_of(area: &str, replica: &Replica, fence: u64) -> Option<Access> {
    (replica.run() > 0 || replica.position() != Position::START).then(|| Access {
        area: area.to_owned(),
        level: Some(level::encode(replica.level())),
        fence,
    })
}
