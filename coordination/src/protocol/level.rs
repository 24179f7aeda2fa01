//! The whole progress of a protocol in plain numbers, for messages and journals.

use super::tree::{Position, Protocol};

/// How far one side knows a protocol to be. This is what sides on two machines send each other.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Level {
    /// Which protocol, in a numbering that both sides agreed on.
    pub protocol: u16,
    /// Which run of it.
    pub run: u32,
    /// Which path the run takes; the first that fits where the flags set so far leave it open.
    pub path: u16,
    /// How many flags are set on that path.
    pub progress: u16,
    /// This run began because the keeper gave up the one before.
    pub after_abort: bool,
}

/// A moment in the life of a protocol; it only ever grows, by run and then by position.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct State {
    pub(super) run: u32,
    pub(super) position: Position,
    pub(super) after_abort: bool,
}

impl State {
    pub(super) const fn start_of(run: u32, after_abort: bool) -> Self {
        Self {
            run,
            position: Position::START,
            after_abort,
        }
    }

    pub(super) const fn at(self, position: Position) -> Self {
        Self { position, ..self }
    }

    /// For channels: run, abort mark and position from the highest bit to the lowest.
    #[cfg(any(test, target_has_atomic = "64"))]
    pub(super) const fn pack(self) -> u64 {
        (self.run as u64) << 32 | (self.after_abort as u64) << 16 | self.position.0 as u64
    }

    #[cfg(any(test, target_has_atomic = "64"))]
    pub(super) const fn unpack(word: u64) -> Self {
        Self {
            run: (word >> 32) as u32,
            position: Position(word as u16),
            after_abort: word >> 16 & 1 == 1,
        }
    }

    pub(super) fn level(self, id: u16, protocol: &Protocol) -> Level {
        Level {
            protocol: id,
            run: self.run,
            path: protocol.path(self.position),
            progress: protocol.progress(self.position),
            after_abort: self.after_abort,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_word_holds_a_state() {
        for run in [0, 1, u32::MAX] {
            for position in [0, 1, u16::MAX] {
                for after_abort in [false, true] {
                    let state = State::start_of(run, after_abort).at(Position(position));
                    assert_eq!(State::unpack(state.pack()), state);
                }
            }
        }
    }
}
