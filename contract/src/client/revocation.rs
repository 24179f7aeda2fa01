//! Revocations of the robot's grants, from its own side.

use std::collections::BTreeMap;

use coordination::protocol::{Position, Replica, Side};

use super::access::{BadLevel, Claims, is_ahead, is_known, report_of};
use super::situation::{ClientCounters, Situation};
use crate::level;
use crate::mention::Mention;
use crate::protocols::{ROBOT_PARTY, RevocationProtocol, begin};
use crate::wire::Access;

#[derive(Clone, Debug)]
struct Revocation {
    replica: Replica,
    /// Of the grant that is asked back.
    fence: u64,
    mention: Mention,
}

impl Revocation {
    /// The grant is asked back, and there is no answer yet.
    fn is_asked(&self) -> bool {
        let at = self.replica.position();
        at != Position::START && !self.replica.protocol().is_end(at)
    }
}

/// The revocations of the robot's grants, by area.
#[derive(Clone, Debug)]
pub(super) struct Revocations {
    protocol: RevocationProtocol,
    by_area: BTreeMap<String, Revocation>,
}

impl Revocations {
    pub(super) fn new() -> Self {
        Self {
            protocol: RevocationProtocol::new(),
            by_area: BTreeMap::new(),
        }
    }

    pub(super) fn forget(&mut self) {
        self.by_area.clear();
    }

    /// Takes over where the mediator left the robot before its restart.
    pub(super) fn inherit(&mut self, message: &Access) -> Result<(), BadLevel> {
        let level = level::decode(message.level.as_ref())?;
        let revocation = Revocation {
            replica: Replica::resume(&self.protocol.protocol, ROBOT_PARTY, level)?,
            fence: message.fence,
            mention: Mention::default(),
        };
        self.by_area.insert(message.area.clone(), revocation);
        Ok(())
    }

    /// Takes in a level.
    pub(super) fn learn(&mut self, message: &Access) -> Result<(), BadLevel> {
        let revocation =
            { self.by_area.entry(message.area.clone()) }.or_insert_with(|| Revocation {
                replica: begin(&self.protocol.protocol, ROBOT_PARTY),
                fence: 0,
                mention: Mention::default(),
            });
        let level = level::decode(message.level.as_ref())?;
        if level.run < revocation.replica.run() {
            revocation.mention.renew();
        }
        let merged = match revocation.replica.merge(level) {
            // What it was asked before it has forgotten, as of areas; there is nothing to answer but this.
            Err(error) if is_ahead(&error) && !revocation.is_asked() && level.progress <= 1 => {
                return self.inherit(message);
            }
            merged => merged,
        };
        while revocation.replica.poll().is_some() {
            revocation.fence = message.fence;
            revocation.mention.renew();
        }
        merged?;
        Ok(())
    }

    /// The grant of this area is asked back, and there is no answer yet.
    pub(super) fn asks_for(&self, area: &str) -> bool {
        self.by_area.get(area).is_some_and(Revocation::is_asked)
    }

    /// Answers what is asked: gives back what the robot neither stands in nor is about to enter. Returns whether there is news.
    pub(super) fn answer(
        &mut self,
        claims: &mut Claims,
        situation: &Situation,
        counters: &mut ClientCounters,
    ) -> bool {
        let mut news = false;
        for (area, revocation) in &mut self.by_area {
            if !revocation.is_asked() {
                continue;
            }
            let (flag, count) = if claims.give_back(area, revocation.fence, situation.needs(area)) {
                (self.protocol.yielded, &mut counters.yielded)
            } else {
                (self.protocol.kept, &mut counters.kept)
            };
            news |= revocation.replica.set(flag).is_ok();
            revocation.mention.renew();
            *count += 1;
        }
        news
    }

    /// For the report, as [`Claims::report`].
    pub(super) fn report(&mut self, number: u64, known: Option<u64>) -> Vec<Access> {
        let said = |(area, own): (&String, &mut Revocation)| {
            let left_out = !own.is_asked() && is_known(&own.mention, known);
            own.mention.note(number);
            let report = report_of(area, &own.replica, own.fence);
            report.filter(|_| !left_out)
        };
        self.by_area.iter_mut().filter_map(said).collect()
    }
}
