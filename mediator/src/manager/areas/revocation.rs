//! The revocation protocol of one robot and one area, from the mediator's side.

use std::collections::BTreeMap;

use contract::mention::Mention;
use contract::protocols::{MEDIATOR_PARTY, RevocationProtocol, begin};
use contract::timing::ASKED_AGAIN_NS;
use coordination::protocol::{Change, Level, MergeError, Position, Replica, Side};

use crate::journal::RevocationRecord;

/// Revocations of one robot's grants of one area.
#[derive(Clone, Debug)]
pub(crate) struct Revocation {
    replica: Replica,
    /// Of the grant that was last asked back.
    fence: u64,
    mention: Mention,
    kept: Kept,
}

/// Whether a robot has kept the grant that it was asked for last.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Kept {
    /// It has not.
    No,
    /// It has, since the last look.
    Now,
    /// It has, since then or earlier.
    Since(u64),
    /// So long ago that it may be asked again.
    LongAgo,
}

/// By area.
pub(crate) type Revocations = BTreeMap<usize, Revocation>;

impl Revocation {
    pub(super) fn new(protocol: &RevocationProtocol) -> Self {
        Self {
            replica: begin(&protocol.protocol, MEDIATOR_PARTY),
            fence: 0,
            mention: Mention::default(),
            kept: Kept::No,
        }
    }

    pub(super) fn resume(
        protocol: &RevocationProtocol,
        record: RevocationRecord,
    ) -> Result<Self, MergeError> {
        Ok(Self {
            replica: Replica::resume(&protocol.protocol, MEDIATOR_PARTY, record.level)?,
            fence: record.fence,
            mention: Mention::default(),
            // If it has not, it has given it back, and is asked for nothing.
            kept: Kept::Now,
        })
    }

    /// Asks for the grant with this fence back: once, and again where its robot has kept it long ago. Returns whether that is new.
    pub(super) fn ask(&mut self, protocol: &RevocationProtocol, fence: u64) -> bool {
        let again = self.kept == Kept::LongAgo;
        if self.fence == fence && !again || self.replica.set(protocol.revoke).is_err() {
            return false;
        }
        (self.fence, self.kept) = (fence, Kept::No);
        self.mention.renew();
        true
    }

    /// It asks for the grant with this fence, and there is no answer yet.
    pub(super) fn asks_for(&self, fence: u64) -> bool {
        self.fence == fence && !self.rests()
    }

    fn rests(&self) -> bool {
        let at = self.replica.position();
        at == Position::START || self.replica.protocol().is_end(at)
    }

    /// Lets time pass. Returns whether its robot may be asked again from now on.
    pub(super) fn grows_old(&mut self, now_ns: u64) -> bool {
        let before = self.kept;
        self.kept = match before {
            Kept::Now => Kept::Since(now_ns),
            Kept::Since(since_ns) if now_ns.saturating_sub(since_ns) >= ASKED_AGAIN_NS => {
                Kept::LongAgo
            }
            other => other,
        };
        self.kept == Kept::LongAgo && before != Kept::LongAgo
    }

    /// Takes in an answer; whether there was something new. Where the journal has lost its last entries the robot knows better. One
    /// that was awaited (`first`) also knows what it is asked; of any other only its number counts, once it has answered: it
    /// would else be asked in runs that are over for it.
    pub(super) fn merge(
        &mut self,
        protocol: &RevocationProtocol,
        level: Level,
        fence: u64,
        first: bool,
    ) -> Result<bool, MergeError> {
        let mut changed = false;
        if let Err(what) = self.replica.merge(level) {
            let fence = if first { fence } else { 0 };
            let said = Self::resume(protocol, RevocationRecord { level, fence })?;
            if !first && !said.rests() {
                return Err(what);
            }
            changed = true;
            *self = said;
        }
        while let Some(change) = self.replica.poll() {
            changed = true;
            if matches!(change, Change::Flag(flag) if flag == protocol.kept) {
                self.kept = Kept::Now;
            }
        }
        if changed || level.run < self.replica.run() {
            self.mention.renew();
        }
        Ok(changed)
    }

    /// Whether a message must mention it, as [`Claim::is_said`](super::claim::Claim::is_said).
    pub(super) fn is_said(&self, known: Option<u64>) -> bool {
        self.fence > 0 && !(self.rests() && known.is_some_and(|heard| self.mention.is_known(heard)))
    }

    pub(super) fn run(&self) -> u32 {
        self.replica.run()
    }

    /// A message of this number is written.
    pub(super) fn note(&mut self, number: u64) {
        self.mention.note(number);
    }

    pub(super) fn record(&self) -> RevocationRecord {
        RevocationRecord {
            level: self.replica.level(),
            fence: self.fence,
        }
    }
}
