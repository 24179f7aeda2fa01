//! Instructions: events that bring parameters for the state that they lead to.

use crate::geometry::Pose2;

/// An event for a robot's state machine with parameters. They hold for the state that the event enters, until that state is
/// left; a transition onto the same state exchanges them if it brings some. An event that the machine ignores brings nothing.
///
/// `E` is the event: its name in messages and requests, its number in the machine.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "pod", derive(serde::Serialize, serde::Deserialize))]
pub struct Instruction<E> {
    /// The event.
    pub event: E,
    /// No faster than this, below every other limit; 0 stands still.
    pub speed_limit_m_s: Option<f64>,
    /// Stop with `base_link` here, in `map`.
    pub stop_at: Option<Pose2>,
}

/// What holds for the present state, until it is left or they are exchanged.
pub type Parameters = Instruction<()>;

impl<E> Instruction<E> {
    /// An event without parameters.
    #[must_use]
    pub const fn plain(event: E) -> Self {
        Self {
            event,
            speed_limit_m_s: None,
            stop_at: None,
        }
    }

    /// The same parameters with another event.
    #[must_use]
    pub const fn with_event<F>(&self, event: F) -> Instruction<F> {
        Instruction {
            event,
            speed_limit_m_s: self.speed_limit_m_s,
            stop_at: self.stop_at,
        }
    }
}
