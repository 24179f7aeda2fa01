//! The rules of a run, as one side sees them: what is new to it, and what it may set.

use alloc::format;
use alloc::string::{String, ToString};
use alloc::vec::Vec;

use thiserror::Error;

use super::level::State;
use super::tree::{FlagId, Party, Position, Protocol};

/// What the other party did.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Change {
    /// It set this flag.
    Flag(FlagId),
    /// It gave up the run; the array is empty. Flags of that run that were not read yet are void.
    Aborted,
}

/// Why a flag was not set. Nothing changed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
#[non_exhaustive]
#[expect(missing_docs, reason = "the messages say what each field is")]
pub enum SetError {
    /// The protocol has no such flag.
    #[error("the protocol has no flag number {}", flag.0)]
    Unknown { flag: FlagId },
    /// The flag belongs to the other party.
    #[error("flag number {} belongs to the other party", flag.0)]
    NotYours { flag: FlagId },
    /// Other flags come first.
    #[error("flag number {} is not next after {} flags", flag.0, at.0)]
    OutOfOrder {
        flag: FlagId,
        /// Where the run is; [`Protocol::next`] lists what is expected there.
        at: Position,
    },
    /// The other party has set a flag that this one has not read.
    #[error("flag number {} of the other party has not been read", unread.0)]
    Unread { unread: FlagId },
    /// The run is complete; the next begins when the other party has read the last flag.
    #[error("the run is complete and the other party has not read its last flag")]
    Complete,
    /// The run was aborted; the next poll says so.
    #[error("the run was aborted and this party has not read that")]
    Aborted,
    /// The last run that has a number is complete.
    #[error("no run number is left")]
    Exhausted,
}

impl SetError {
    /// The error in the protocol's names. Allocates.
    #[must_use]
    pub fn describe(&self, protocol: &Protocol) -> String {
        let name = |flag| protocol.flag_name(flag);
        let text = match *self {
            Self::NotYours { flag } => {
                let owner = protocol.owner(flag).map(|party| protocol.party_name(party));
                let owner = owner.unwrap_or("?");
                format!("flag `{}` belongs to `{owner}`", name(flag))
            }
            Self::OutOfOrder { flag, at } => {
                let expected: Vec<_> = protocol.next(at).map(|(flag, _)| name(flag)).collect();
                format!(
                    "flag `{}` is out of order: expected `{}` after {}",
                    name(flag),
                    expected.join("` or `"),
                    protocol.describe(at)
                )
            }
            Self::Unread { unread } => {
                format!("flag `{}` has not been read", name(unread))
            }
            Self::Unknown { .. } | Self::Complete | Self::Aborted | Self::Exhausted => {
                self.to_string()
            }
        };
        format!("protocol `{}`: {text}", protocol.name())
    }
}

/// Why a run was not aborted. Nothing changed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum AbortError {
    /// Only the keeper may, and this party is not it.
    #[error("only the protocol's keeper may abort a run")]
    NotKeeper,
    /// There is no number for the run that would follow.
    #[error("no run number is left")]
    Exhausted,
    /// A side of a [`NetBinding`](crate::binding::NetBinding) was exchanged for one that does not belong there.
    #[error("a side is of another protocol or party than the one that the net was bound to")]
    OtherSide,
}

/// One party's side of a protocol, whatever connects it to the other.
pub trait Side {
    /// The protocol.
    fn protocol(&self) -> &Protocol;
    /// The party on this side.
    fn party(&self) -> Party;
    /// Up to where this party has read or set the flags of its run.
    fn read_to(&self) -> Position;
    /// Sets a flag of this party; an error changes nothing.
    ///
    /// # Errors
    /// If the flag is unknown, not this party's or not next, or if the other party's flags or abort
    /// are still to be read; see [`SetError`].
    fn set(&mut self, flag: FlagId) -> Result<(), SetError>;
    /// What the next [`poll`](Self::poll) would return, without reading it.
    fn peek(&self) -> Option<Change>;
    /// Reads what the other party did: each of its flags exactly once and in order. Reading the
    /// last flag of a run empties the array for the next.
    fn poll(&mut self) -> Option<Change>;
    /// Gives up the present run and begins the next, if this party is the keeper. Returns how far
    /// the run had come, flags not read included; an empty array stays as it is.
    ///
    /// # Errors
    /// If this party is not the keeper, or no run number is left.
    fn abort(&mut self) -> Result<Position, AbortError>;
}

/// The state that follows the end of a run or its abort; nothing after the last run.
pub(super) fn next_run(state: State, after_abort: bool) -> Option<State> {
    Some(State::start_of(state.run.checked_add(1)?, after_abort))
}

/// Where this party stands, seen from `now`, if it has read everything up to the present run.
///
/// A run that ends needs this party, as setter or as reader of the last flag. So if the run number
/// went up by one without an abort, this party had set the last flag and knows the old run whole;
/// any other rise of it is an abort.
fn in_present_run(read: State, now: State) -> Option<State> {
    if read.run == now.run {
        Some(read)
    } else if read.run.checked_add(1) == Some(now.run) && !now.after_abort {
        Some(State::start_of(now.run, false))
    } else {
        None
    }
}

/// The next change that a party that has read up to `read` finds in `now`, and how far it has then
/// read.
pub(super) fn look(protocol: &Protocol, read: State, now: State) -> Option<(Change, State)> {
    let Some(read) = in_present_run(read, now) else {
        let start = State::start_of(now.run, now.after_abort);
        return Some((Change::Aborted, start));
    };
    let (flag, position) = protocol.towards(read.position, now.position)?;
    Some((Change::Flag(flag), read.at(position)))
}

/// Where setting `flag` leads, if `party`, having read up to `read`, may set it in `now`.
pub(super) fn may_set(
    protocol: &Protocol,
    party: Party,
    read: State,
    now: State,
    flag: FlagId,
) -> Result<State, SetError> {
    let owner = protocol.owner(flag).ok_or(SetError::Unknown { flag })?;
    if owner != party {
        return Err(SetError::NotYours { flag });
    }
    match look(protocol, read, now) {
        Some((Change::Aborted, _)) => return Err(SetError::Aborted),
        Some((Change::Flag(unread), _)) => return Err(SetError::Unread { unread }),
        None => {}
    }
    if protocol.is_end(now.position) {
        return Err(match next_run(now, false) {
            Some(_) => SetError::Complete,
            None => SetError::Exhausted,
        });
    }
    let next = protocol.after(now.position, flag);
    let at = now.position;
    next.map(|position| now.at(position))
        .ok_or(SetError::OutOfOrder { flag, at })
}
