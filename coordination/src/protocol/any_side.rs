//! Sides of different kinds as one.

use alloc::boxed::Box;

use super::channel::End;
use super::cursor::{AbortError, Change, SetError, Side};
use super::replica::Replica;
use super::tree::{FlagId, Party, Position, Protocol};

/// A side to another thread or to another machine, so that both kinds can stand in one list, as those of
/// a [`NetBinding`](crate::binding::NetBinding) do. Sides of a user's own kind are one as `Box<dyn Side>`.
#[derive(Debug)]
pub enum AnySide {
    /// The other party is a thread of this machine.
    Thread(End),
    /// The other party is on another machine.
    Machine(Replica),
}

impl AnySide {
    /// The replica, to send its level and to merge levels into it.
    #[must_use]
    pub fn replica_mut(&mut self) -> Option<&mut Replica> {
        match self {
            Self::Thread(_) => None,
            Self::Machine(replica) => Some(replica),
        }
    }

    fn side(&self) -> &dyn Side {
        match self {
            Self::Thread(end) => end,
            Self::Machine(replica) => replica,
        }
    }

    fn side_mut(&mut self) -> &mut dyn Side {
        match self {
            Self::Thread(end) => end,
            Self::Machine(replica) => replica,
        }
    }
}

impl From<End> for AnySide {
    fn from(end: End) -> Self {
        Self::Thread(end)
    }
}

impl From<Replica> for AnySide {
    fn from(replica: Replica) -> Self {
        Self::Machine(replica)
    }
}

/// Implements [`Side`] by another side, which `$self` has or points to.
macro_rules! side_by {
    ([$($generics:tt)*] $type:ty, $self:ident, $side:expr, $side_mut:expr) => {
        impl<$($generics)*> Side for $type {
            fn protocol(&$self) -> &Protocol {
                $side.protocol()
            }

            fn party(&$self) -> Party {
                $side.party()
            }

            fn read_to(&$self) -> Position {
                $side.read_to()
            }

            fn set(&mut $self, flag: FlagId) -> Result<(), SetError> {
                $side_mut.set(flag)
            }

            fn peek(&$self) -> Option<Change> {
                $side.peek()
            }

            fn poll(&mut $self) -> Option<Change> {
                $side_mut.poll()
            }

            fn abort(&mut $self) -> Result<Position, AbortError> {
                $side_mut.abort()
            }
        }
    };
}
side_by!([] AnySide, self, self.side(), self.side_mut());
side_by!([S: Side + ?Sized] Box<S>, self, (**self), (**self));
side_by!([S: Side + ?Sized] &mut S, self, (**self), (**self));
