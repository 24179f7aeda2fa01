//! Instructions: events that bring parameters for the state that they enter.

use super::output::MAX_EVENTS;
use coordination::event::EventId;
use description::geometry::Pose2;

/// An event for the machine with parameters. They hold for the state that the event enters, until that state is left; a
/// transition onto the same state exchanges them if it brings some. An event that the machine ignores brings nothing.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Instruction {
    /// The event.
    pub event: EventId,
    /// No faster than this, below every other limit; 0 stands still.
    pub speed_limit_m_s: Option<f64>,
    /// Stop with `base_link` here, in `map`.
    pub stop_at: Option<Pose2>,
}

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

impl Instruction {
    /// An event without parameters.
    #[must_use]
    pub fn plain(event: EventId) -> Self {
        Self {
            event,
            speed_limit_m_s: None,
            stop_at: None,
        }
    }

    /// Checks the parameters.
    ///
    /// # Errors
    /// [`InstructionError::SpeedLimit`] or [`InstructionError::StopPose`].
    pub fn validate(&self) -> Result<(), InstructionError> {
        self.parameters().validate()
    }

    pub(super) fn parameters(&self) -> Parameters {
        Parameters {
            speed_limit_m_s: self.speed_limit_m_s,
            stop_at: self.stop_at,
        }
    }
}

/// What holds for the present state, until it is left or they are exchanged.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Parameters {
    /// No faster than this, below every other limit; 0 stands still.
    pub speed_limit_m_s: Option<f64>,
    /// Stop with `base_link` here, in `map`.
    pub stop_at: Option<Pose2>,
}

impl Parameters {
    /// Checks them.
    ///
    /// # Errors
    /// [`InstructionError::SpeedLimit`] or [`InstructionError::StopPose`].
    pub fn validate(&self) -> Result<(), InstructionError> {
        if let Some(limit_m_s) = self.speed_limit_m_s
            && !(limit_m_s.is_finite() && limit_m_s >= 0.0)
        {
            return Err(InstructionError::SpeedLimit(limit_m_s));
        }
        match self.stop_at {
            Some(pose) if !pose.is_finite() => Err(InstructionError::StopPose),
            _ => Ok(()),
        }
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
