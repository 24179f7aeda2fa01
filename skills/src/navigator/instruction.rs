//! Instructions for the machine: what is refused, what waits, and what became of one.

use coordination::event::EventId;
use coordination::fsm::StateId;
use description::instruction;

use super::output::MAX_EVENTS;
use crate::schedule::Hold;

pub use description::instruction::Parameters;

/// An instruction whose event is a number of the machine.
pub type Instruction = instruction::Instruction<EventId>;

/// Why an instruction was not taken.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum InstructionError {
    /// The speed limit.
    #[error("speed limit must be zero or more, found {0} m/s")]
    SpeedLimit(f64),
    /// The stop pose.
    #[error("stop pose is not finite")]
    StopPose,
    /// Too many wait.
    #[error("{MAX_EVENTS} events wait already")]
    Full,
}

/// What became of an instruction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Instructed {
    /// The machine took the event.
    Taken {
        /// The state it was in.
        from: StateId,
        /// The state it is in now.
        to: StateId,
        /// Why the robot does not move in it, if it does not.
        hold: Option<Hold>,
    },
    /// The machine has no use for the event in this state.
    Ignored {
        /// The state.
        state: StateId,
    },
    /// The parameters are bad, or too many events wait.
    Refused(InstructionError),
    /// Navigation does not run yet, or any more, or another instruction is being answered.
    NotReady,
}

/// Checks parameters.
pub(super) fn validate<E>(
    instruction: &instruction::Instruction<E>,
) -> Result<(), InstructionError> {
    if let Some(limit_m_s) = instruction.speed_limit_m_s
        && !(limit_m_s.is_finite() && limit_m_s >= 0.0)
    {
        return Err(InstructionError::SpeedLimit(limit_m_s));
    }
    match instruction.stop_at {
        Some(pose) if !pose.is_finite() => Err(InstructionError::StopPose),
        _ => Ok(()),
    }
}

/// Instructions that wait for the next step, in their order, without allocation.
#[derive(Clone, Debug)]
pub(super) struct Inbox {
    waiting: [Instruction; MAX_EVENTS],
    len: usize,
}

impl Default for Inbox {
    fn default() -> Self {
        Self {
            waiting: [Instruction::plain(EventId(0)); MAX_EVENTS],
            len: 0,
        }
    }
}

impl Inbox {
    /// Adds one; `false` when the list is full.
    pub(super) fn push(&mut self, instruction: Instruction) -> bool {
        let Some(place) = self.waiting.get_mut(self.len) else {
            return false;
        };
        *place = instruction;
        self.len += 1;
        true
    }

    /// Takes the first one out.
    pub(super) fn pop_front(&mut self) -> Option<Instruction> {
        let first = *self.waiting[..self.len].first()?;
        self.waiting.copy_within(1..self.len, 0);
        self.len -= 1;
        Some(first)
    }
}
