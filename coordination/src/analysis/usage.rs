//! What a net is analysed with: protocols, situations, limits.

use std::sync::Arc;
use std::time::Duration;

use super::flags::NamedProtocol;
use crate::petri::NetModel;
use crate::protocol::{Party, Position, Protocol};

/// A protocol that the net takes part in, under the name that the net's bindings call it.
#[derive(Clone, Debug)]
pub struct Use {
    /// The name in [`Binding::Flag`](crate::petri::Binding::Flag).
    pub name: String,
    /// The protocol.
    pub protocol: Arc<Protocol>,
    /// Which of its parties the net is.
    pub net_party: Party,
}

impl Use {
    /// Protocol `protocol` under the name `name`.
    pub fn new(name: impl Into<String>, protocol: Arc<Protocol>, net_party: Party) -> Self {
        Self {
            name: name.into(),
            protocol,
            net_party,
        }
    }

    pub(super) fn named(&self) -> NamedProtocol<'_> {
        NamedProtocol {
            name: &self.name,
            protocol: &self.protocol,
            net_party: self.net_party,
        }
    }

    /// Where the protocol is once `to` is reached: a complete run makes room for the next.
    pub(super) fn after(&self, to: Position) -> Position {
        if self.protocol.is_end(to) {
            Position::START
        } else {
            to
        }
    }

    /// The name of the party that the net is.
    #[must_use]
    pub fn net_party_name(&self) -> &str {
        self.protocol.party_name(self.net_party)
    }

    /// The name of the other party.
    #[must_use]
    pub fn other_party_name(&self) -> &str {
        self.protocol.party_name(self.net_party.other())
    }
}

/// One of several initial markings of a net.
#[derive(Clone, Copy, Debug)]
pub struct Situation<'a> {
    /// Its name, for reports.
    pub name: &'a str,
    /// The net with that marking.
    pub model: &'a NetModel,
}

/// How far an analysis goes before it gives up and refuses the net.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Limits {
    /// States. Each takes some tens of bytes and a bit for each place.
    pub states: usize,
    /// Steps from one state to another, over all states. Each takes eight bytes. And as many steps, which take some
    /// tens of bytes, of the ways that [`properties`](super::properties()) names to where transitions die.
    pub steps: usize,
    /// Transitions, sinks and protocols looked at, over all states: what bounds the time. And as many numbers in the search
    /// for [place invariants](super::place_invariants()), which ends there with what it has found.
    pub looks: u64,
    /// With the feature `symbolic`: nodes of decision diagrams, in which a net is looked at that has more
    /// states or steps than these limits allow. Each takes some tens of bytes; 2²⁸ at most (2²⁴ where addresses have 32 bits).
    pub nodes: usize,
    /// The time for that.
    pub time: Duration,
    /// Events that may wait for one full source. A net with flags in a good order needs none.
    pub waiting: u8,
}

impl Default for Limits {
    fn default() -> Self {
        Self {
            states: 200_000,
            steps: 4_000_000,
            looks: 200_000_000,
            nodes: 4_000_000,
            time: Duration::from_secs(60),
            waiting: 4,
        }
    }
}
