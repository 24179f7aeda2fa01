//! Event names and their dense ids.

use alloc::borrow::ToOwned;
use alloc::collections::BTreeMap;
use alloc::string::String;
use alloc::vec::Vec;

use thiserror::Error;

/// A dense event id, valid in the [`EventTable`] that gave it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct EventId(pub u16);

impl EventId {
    /// The id as an index into an array with one entry per event.
    #[must_use]
    pub fn index(self) -> usize {
        usize::from(self.0)
    }
}

/// The table already holds as many events as an [`EventId`] can tell apart.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[error(
    "no id left for event `{name}`: a table holds at most {} events",
    EventTable::MAX_EVENTS
)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct TooManyEvents {
    /// The event that found no room.
    pub name: String,
}

/// Names of events and their ids; ids count up from 0 without holes.
#[derive(Clone, Debug, Default)]
pub struct EventTable {
    names: Vec<String>,
    ids: BTreeMap<String, EventId>,
}

impl EventTable {
    /// The most events that one table holds.
    pub const MAX_EVENTS: usize = u16::MAX as usize;

    /// A table without events.
    #[must_use]
    pub fn new() -> Self {
        Self::default()
    }

    /// The id of `name`, which is added if it is new. Not for real-time threads.
    ///
    /// # Errors
    /// [`TooManyEvents`] if the name is new and there are [`MAX_EVENTS`](Self::MAX_EVENTS).
    pub fn intern(&mut self, name: &str) -> Result<EventId, TooManyEvents> {
        if let Some(id) = self.id(name) {
            return Ok(id);
        }
        if self.names.len() >= Self::MAX_EVENTS {
            return Err(TooManyEvents {
                name: name.to_owned(),
            });
        }
        let id = EventId(self.names.len() as u16);
        self.names.push(name.to_owned());
        self.ids.insert(name.to_owned(), id);
        Ok(id)
    }

    /// The id of `name`, if the table knows it.
    #[must_use]
    pub fn id(&self, name: &str) -> Option<EventId> {
        self.ids.get(name).copied()
    }

    /// The name of `id`, if the table gave that id.
    pub fn name(&self, id: EventId) -> Option<&str> {
        self.names.get(id.index()).map(String::as_str)
    }

    /// How many events the table holds.
    #[must_use]
    pub fn len(&self) -> usize {
        self.names.len()
    }

    /// Whether the table holds no event.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.names.is_empty()
    }

    /// All events in the order of their ids.
    pub fn iter(&self) -> impl Iterator<Item = (EventId, &str)> {
        self.names
            .iter()
            .enumerate()
            .map(|(index, name)| (EventId(index as u16), name.as_str()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ids_are_dense_and_stable() {
        let mut events = EventTable::new();
        let a = events.intern("a").unwrap();
        let b = events.intern("b").unwrap();
        assert_eq!((a, b), (EventId(0), EventId(1)));
        assert_eq!(events.intern("a").unwrap(), a);
        assert_eq!(events.id("b"), Some(b));
        assert_eq!(events.id("c"), None);
        assert_eq!(events.name(b), Some("b"));
        assert_eq!(events.name(EventId(2)), None);
        assert_eq!(events.iter().collect::<Vec<_>>(), [(a, "a"), (b, "b")]);
    }

    #[test]
    fn a_full_table_refuses_new_names_and_still_knows_the_old() {
        let mut events = EventTable::new();
        for number in 0..EventTable::MAX_EVENTS {
            events.intern(&format!("e{number}")).unwrap();
        }
        assert_eq!(
            events.intern("one too many").unwrap_err().name,
            "one too many"
        );
        assert_eq!(events.intern("e7").unwrap(), EventId(7));
    }
}
