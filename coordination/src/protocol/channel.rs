//! A protocol between two threads, over one atomic word.
//!
//! The word holds the run, the position and the abort mark ([`State::pack`]). It only changes by
//! compare-and-exchange from the value that a rule was checked against. Because at every moment one
//! party alone may write, except for the keeper, a failed exchange means that the keeper aborted.

use alloc::sync::Arc;

use super::cursor::{AbortError, Change, SetError, Side, look, may_set, next_run};
use super::level::{Level, State};
use super::sync::{AtomicBool, AtomicU64, Ordering};
use super::tree::{FlagId, Party, Position, Protocol};

/// The two ends of a protocol, in the order of its parties, in run 0. Allocates.
#[must_use]
pub fn channel(protocol: &Arc<Protocol>) -> (End, End) {
    channel_at(protocol, 0)
}

/// The two ends of a protocol, in the order of its parties, in the run with the given number.
#[must_use]
pub fn channel_at(protocol: &Arc<Protocol>, run: u32) -> (End, End) {
    let start = State::start_of(run, false);
    let shared = Arc::new(Shared {
        word: AtomicU64::new(start.pack()),
        gone: [AtomicBool::new(false), AtomicBool::new(false)],
    });
    let end = |party| End {
        protocol: Arc::clone(protocol),
        shared: Arc::clone(&shared),
        party,
        read: start,
    };
    (end(Party::First), end(Party::Second))
}

/// What both ends see.
#[derive(Debug)]
struct Shared {
    word: AtomicU64,
    /// By party: whether its end was dropped.
    gone: [AtomicBool; 2],
}

/// One party's end of a protocol between two threads.
///
/// What a party wrote to memory before it set a flag is visible to the other once it has read the
/// flag.
///
/// **Real time:** every function is wait-free and does not allocate.
#[derive(Debug)]
pub struct End {
    protocol: Arc<Protocol>,
    shared: Arc<Shared>,
    party: Party,
    /// What this party has read or written itself.
    read: State,
}

impl End {
    /// The run that this party last set or read a flag in, or polled in without finding any.
    #[must_use]
    pub fn run(&self) -> u32 {
        self.read.run
    }

    /// How far this party has read or written that run.
    #[must_use]
    pub fn position(&self) -> Position {
        self.read.position
    }

    /// How far the protocol is, read or not. `id` is the protocol's number between the sides.
    #[must_use]
    pub fn level(&self, id: u16) -> Level {
        self.now().level(id, &self.protocol)
    }

    /// Whether the other end is gone, so that nobody will read or set. All that it set before is
    /// there for whoever polls after that.
    #[must_use]
    pub fn is_abandoned(&self) -> bool {
        self.shared.gone[self.party.other().index()].load(Ordering::Acquire)
    }

    fn now(&self) -> State {
        State::unpack(self.shared.word.load(Ordering::Acquire))
    }

    /// Replaces `from` by `to`, which this party then knows; `false` if `from` is no longer there.
    fn exchange(&mut self, from: State, to: State) -> bool {
        let (release, acquire) = (Ordering::AcqRel, Ordering::Acquire);
        let exchanged = self
            .shared
            .word
            .compare_exchange(from.pack(), to.pack(), release, acquire)
            .is_ok();
        if exchanged {
            self.read = to;
        }
        exchanged
    }
}

impl Drop for End {
    fn drop(&mut self) {
        // Released, so that whoever sees it sees the last flags too.
        self.shared.gone[self.party.index()].store(true, Ordering::Release);
    }
}

impl Side for End {
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
        let now = self.now();
        let to = may_set(&self.protocol, self.party, self.read, now, flag)?;
        if self.exchange(now, to) {
            Ok(())
        } else {
            Err(SetError::Aborted)
        }
    }

    fn peek(&self) -> Option<Change> {
        look(&self.protocol, self.read, self.now()).map(|(change, _)| change)
    }

    fn poll(&mut self) -> Option<Change> {
        let now = self.now();
        let Some((change, read)) = look(&self.protocol, self.read, now) else {
            // The other party may have emptied the array.
            self.read = now;
            return None;
        };
        self.read = read;
        if self.protocol.is_end(read.position)
            && let Some(next) = next_run(read, false)
        {
            // Fails if the keeper aborted in between; the next poll reads that.
            self.exchange(read, next);
        }
        Some(change)
    }

    /// Repeats while the other party sets flags in between, which it can do at most as often as
    /// the protocol has entries before it needs an answer.
    fn abort(&mut self) -> Result<Position, AbortError> {
        if self.protocol.keeper() != Some(self.party) {
            return Err(AbortError::NotKeeper);
        }
        loop {
            let now = self.now();
            if now.position == Position::START {
                return Ok(now.position);
            }
            let next = next_run(now, true).ok_or(AbortError::Exhausted)?;
            if self.exchange(now, next) {
                return Ok(now.position);
            }
        }
    }
}
