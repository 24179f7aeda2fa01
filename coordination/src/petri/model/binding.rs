//! What the places of a net are to the world outside.

use alloc::format;
use alloc::string::String;

/// What a source or a sink is bound to.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum Binding {
    /// An event of that name.
    Event(String),
    /// A flag of a protocol array.
    Flag {
        /// The protocol's name.
        protocol: String,
        /// The flag's name.
        flag: String,
    },
}

impl Binding {
    /// A binding to the event called `name`.
    pub fn event(name: impl Into<String>) -> Self {
        Self::Event(name.into())
    }

    /// A binding to the flag called `flag` of the protocol called `protocol`.
    pub fn flag(protocol: impl Into<String>, flag: impl Into<String>) -> Self {
        Self::Flag {
            protocol: protocol.into(),
            flag: flag.into(),
        }
    }

    /// The name in the [`EventTable`](crate::event::EventTable): the event's own, or `<protocol>.<flag>`.
    #[must_use]
    pub fn event_name(&self) -> String {
        match self {
            Self::Event(name) => name.clone(),
            Self::Flag { protocol, flag } => format!("{protocol}.{flag}"),
        }
    }
}

/// Who marks and who empties a place.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum PlaceKind {
    /// The net's transitions mark and empty it.
    Internal,
    /// An incoming event or flag marks it.
    Source,
    /// Its mark is an outgoing event or flag; whoever consumes that empties it.
    Sink,
}
