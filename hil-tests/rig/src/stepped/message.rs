//! Messages between robots and mediators, and what may happen to them on their way.

use crate::scenario::{Direction, WhichMediator};

/// A message, encoded; robots have the numbers that they have in the scenario.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Message {
    pub(super) robot: usize,
    pub(super) kind: MessageKind,
    pub(super) bytes: Vec<u8>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum MessageKind {
    /// Of a robot to everybody.
    State,
    /// Of a robot to the mediator.
    Report,
    /// The same to the second mediator, on a way of its own.
    SecondReport,
    /// Of the mediator to a robot.
    Answer,
    /// The same of the second mediator.
    SecondAnswer,
}

impl MessageKind {
    /// Which way it goes, and from or to which mediator if not to everybody.
    pub(super) fn way(self) -> (Direction, Option<WhichMediator>) {
        match self {
            Self::State => (Direction::ToMediator, None),
            Self::Report => (Direction::ToMediator, Some(WhichMediator::First)),
            Self::SecondReport => (Direction::ToMediator, Some(WhichMediator::Second)),
            Self::Answer => (Direction::ToRobots, Some(WhichMediator::First)),
            Self::SecondAnswer => (Direction::ToRobots, Some(WhichMediator::Second)),
        }
    }
}

/// What happens to messages of one robot at a time.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Weather {
    pub(super) lost: f64,
    pub(super) repeated: f64,
    pub(super) delay_ns: f64,
}
