//! A protocol between two machines: each holds a replica and sends the other its level.

use alloc::sync::Arc;
use core::fmt;

use thiserror::Error;

use super::cursor::{AbortError, Change, SetError, Side, look, may_set, next_run};
use super::level::{Level, State};
use super::tree::{FlagId, Party, Position, Protocol};

/// What was new in a level of the other side.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Merged {
    /// Nothing that was not known: it is repeated, late, or nothing has happened.
    Nothing,
    /// The other side has set flags, or has read the end of the run; poll reads the flags.
    Risen,
    /// The other side, the keeper, has given up the run.
    Aborted,
}

/// Why a level was refused. Nothing changed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
#[non_exhaustive]
#[expect(missing_docs, reason = "the messages say what each field is")]
pub enum MergeError {
    /// It is a level of another protocol.
    #[error("expected a level of protocol {expected}, found one of protocol {found}")]
    OtherProtocol { expected: u16, found: u16 },
    /// The protocol has no such path, or the path is shorter.
    #[error("the protocol has no path {path} with {progress} flags set")]
    NoSuchPosition { path: u16, progress: u16 },
    /// The other side says that a flag of this side is set, which this side has not set.
    #[error("the other side claims flag number {}, which is not its own", flag.0)]
    ClaimsMine { flag: FlagId },
    /// The two sides took different paths.
    #[error("the other side is on path {path}, which this run has left at {}", mine.0)]
    OtherPath { path: u16, mine: Position },
    /// The other side is in a later run that it had no right to begin. Sides that have lost each
    /// other's past agree on a new run ([`Replica::restart`]) or on a level ([`Replica::resume`]).
    #[error("the other side is in run {found}, and run {present} is not over")]
    UnexpectedRun { present: u32, found: u32 },
}

/// Runs only go forward; nothing changed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
#[error("run {asked} is not later than run {present}")]
#[expect(missing_docs, reason = "the message says what each field is")]
pub struct RunNotNewer {
    pub present: u32,
    pub asked: u32,
}

/// One side of a protocol between two machines. It needs no clock and sends nothing itself: its
/// owner sends [`level`](Self::level) now and then, and [merges](Self::merge) what arrives.
#[derive(Clone)]
pub struct Replica {
    protocol: Arc<Protocol>,
    id: u16,
    party: Party,
    /// The furthest that both sides together are known to be.
    known: State,
    /// What the owner has read or written of that.
    read: State,
}

/// The protocol by its name: it never changes, and is larger than all the rest.
impl fmt::Debug for Replica {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Replica")
            .field("protocol", &self.protocol.name())
            .field("id", &self.id)
            .field("party", &self.party)
            .field("known", &self.known)
            .field("read", &self.read)
            .finish()
    }
}

impl Replica {
    /// The side of `party` of the protocol that both sides number `id`, before the first flag of
    /// run `run`. The side that numbers runs tells the other.
    #[must_use]
    pub fn new(protocol: &Arc<Protocol>, id: u16, party: Party, run: u32) -> Self {
        let start = State::start_of(run, false);
        Self {
            protocol: Arc::clone(protocol),
            id,
            party,
            known: start,
            read: start,
        }
    }

    /// The side of `party` where `level` left it, all of it read: for a side that restarts from a
    /// journal or from what the other side reports.
    ///
    /// # Errors
    /// [`MergeError::NoSuchPosition`] if the protocol cannot be where the level says.
    pub fn resume(
        protocol: &Arc<Protocol>,
        party: Party,
        level: Level,
    ) -> Result<Self, MergeError> {
        let mut replica = Self::new(protocol, level.protocol, party, level.run);
        let position = replica.position_of(level)?;
        replica.known = State::start_of(level.run, level.after_abort).at(position);
        replica.read = replica.known;
        replica.empty_if_read();
        Ok(replica)
    }

    /// The level to send and to repeat.
    #[must_use]
    pub fn level(&self) -> Level {
        self.known.level(self.id, &self.protocol)
    }

    /// The level up to where the owner has read or set flags: what to store, so that after a restart
    /// the rest comes again with the other side's next level.
    #[must_use]
    pub fn read_level(&self) -> Level {
        self.read.level(self.id, &self.protocol)
    }

    /// The run that both sides together are known to be in.
    #[must_use]
    pub fn run(&self) -> u32 {
        self.known.run
    }

    /// How far both sides together are known to be.
    #[must_use]
    pub fn position(&self) -> Position {
        self.known.position
    }

    /// Takes over what is new in a level of the other side. Levels may be lost, repeated, late and
    /// out of order. After an error nothing has changed. Does not allocate.
    ///
    /// # Errors
    /// [`MergeError`] if the level cannot come from an honest other side of this protocol.
    pub fn merge(&mut self, level: Level) -> Result<Merged, MergeError> {
        let to = self.position_of(level)?;
        let (from, aborted) = match level.run.checked_sub(self.known.run) {
            None => return Ok(Merged::Nothing),
            Some(0) => (self.known, false),
            Some(1) if !level.after_abort && self.ended_here() => {
                (State::start_of(level.run, false), false)
            }
            Some(_) if level.after_abort && self.protocol.keeper() == Some(self.party.other()) => {
                (State::start_of(level.run, true), true)
            }
            Some(_) => {
                return Err(MergeError::UnexpectedRun {
                    present: self.known.run,
                    found: level.run,
                });
            }
        };
        if self.protocol.leads(to, from.position) && from.run == self.known.run {
            return Ok(Merged::Nothing);
        }
        if !self.protocol.leads(from.position, to) {
            return Err(MergeError::OtherPath {
                path: level.path,
                mine: from.position,
            });
        }
        let mut at = from.position;
        while let Some((flag, next)) = self.protocol.towards(at, to) {
            if self.protocol.owner(flag) == Some(self.party) {
                return Err(MergeError::ClaimsMine { flag });
            }
            at = next;
        }
        self.known = from.at(to);
        Ok(if aborted {
            Merged::Aborted
        } else {
            Merged::Risen
        })
    }

    /// Gives up the present run and goes to the start of `run`, the number that the other side has
    /// given out. Unread flags are void, and no poll reports this. A level of the keeper that
    /// restarted reads as an abort on the other side.
    ///
    /// # Errors
    /// [`RunNotNewer`] unless `run` is above the present run; nothing has changed.
    pub fn restart(&mut self, run: u32) -> Result<(), RunNotNewer> {
        if run <= self.known.run {
            return Err(RunNotNewer {
                present: self.known.run,
                asked: run,
            });
        }
        self.known = State::start_of(run, true);
        self.read = self.known;
        Ok(())
    }

    fn position_of(&self, level: Level) -> Result<Position, MergeError> {
        if level.protocol != self.id {
            return Err(MergeError::OtherProtocol {
                expected: self.id,
                found: level.protocol,
            });
        }
        let (path, progress) = (level.path, level.progress);
        self.protocol
            .position(path, progress)
            .ok_or(MergeError::NoSuchPosition { path, progress })
    }

    /// Whether this side has set the last flag of the run, so that the other begins the next.
    fn ended_here(&self) -> bool {
        let position = self.known.position;
        let last = self.protocol.before(position);
        self.protocol.is_end(position)
            && last.is_some_and(|(flag, _)| self.protocol.owner(flag) == Some(self.party))
    }

    /// Empties the array if this side has read the last flag, set by the other.
    fn empty_if_read(&mut self) {
        if self.read == self.known
            && self.protocol.is_end(self.known.position)
            && !self.ended_here()
            && let Some(next) = next_run(self.known, false)
        {
            self.known = next;
            self.read = next;
        }
    }
}

impl Side for Replica {
    fn protocol(&self) -> &Protocol {
        &self.protocol
    }

    fn party(&self) -> Party {
        self.party
    }

    fn read_to(&self) -> Position {
        self.read.position
    }

    fn set(&mut self, flag: FlagId) -> Result<(), SetError> {
        self.known = may_set(&self.protocol, self.party, self.read, self.known, flag)?;
        self.read = self.known;
        Ok(())
    }

    fn peek(&self) -> Option<Change> {
        look(&self.protocol, self.read, self.known).map(|(change, _)| change)
    }

    fn poll(&mut self) -> Option<Change> {
        let (change, read) = look(&self.protocol, self.read, self.known)?;
        self.read = read;
        self.empty_if_read();
        Some(change)
    }

    fn abort(&mut self) -> Result<Position, AbortError> {
        if self.protocol.keeper() != Some(self.party) {
            return Err(AbortError::NotKeeper);
        }
        let position = self.known.position;
        if position != Position::START {
            self.known = next_run(self.known, true).ok_or(AbortError::Exhausted)?;
            self.read = self.known;
        }
        Ok(position)
    }
}
