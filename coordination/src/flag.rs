//! Flags (the paper's Section 1.2): Boolean conditions over the data of an activity, and the events that their changes are.
//!
//! A [`Flag`] is one condition. Whoever evaluates the condition [sets](Flag::set) it, as often as it likes; what comes back is the
//! [`Change`], if there is one. A [`Monitor`] turns a rise, a fall, or either into an event for a machine, a net or a queue. What a
//! flag is at first is no change and so no event.
//!
//! A flag belongs to one activity. What two activities share is a symbol, or a flag of a [`protocol`](crate::protocol), which also says
//! whose turn it is to set it.
//!
//! **Real time:** nothing here allocates, locks or makes a system call.
//!
//! ```
//! use coordination::event::EventTable;
//! use coordination::flag::{Edge, Flag, Monitor};
//!
//! let mut events = EventTable::new();
//! let stop = Monitor::on_rise(events.intern("stop")?);
//! let go = Monitor { edge: Edge::Fall, event: events.intern("go")? };
//!
//! let (mut blocked, near_m, mut fired) = (Flag::new(false), 0.3, Vec::new());
//! for distance_m in [1.0, 0.2, 0.1, 0.8] {
//!     if let Some(change) = blocked.set(distance_m < near_m) {
//!         fired.extend([stop, go].iter().filter_map(|monitor| monitor.event_of(change)));
//!     }
//! }
//! assert_eq!(fired, [stop.event, go.event]);
//! assert_eq!(blocked.rises(), 1);
//! # Ok::<(), coordination::event::TooManyEvents>(())
//! ```

use crate::event::EventId;

/// How a flag changed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Change {
    /// From false to true.
    Rise,
    /// From true to false.
    Fall,
}

/// Which changes a monitor tells.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Edge {
    /// Rises.
    Rise,
    /// Falls.
    Fall,
    /// Both.
    Either,
}

/// A Boolean condition as it was evaluated last, and how often it changed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Flag {
    is_set: bool,
    rises: u64,
    falls: u64,
}

impl Flag {
    /// A flag that is so at first, which is no change.
    #[must_use]
    pub const fn new(is_set: bool) -> Self {
        Self {
            is_set,
            rises: 0,
            falls: 0,
        }
    }

    /// Whether the condition holds, as far as is known.
    #[must_use]
    pub const fn is_set(&self) -> bool {
        self.is_set
    }

    /// Notes whether the condition holds now. Returns what that changes. Real time.
    pub const fn set(&mut self, holds: bool) -> Option<Change> {
        if holds == self.is_set {
            return None;
        }
        self.is_set = holds;
        Some(if holds {
            self.rises = self.rises.saturating_add(1);
            Change::Rise
        } else {
            self.falls = self.falls.saturating_add(1);
            Change::Fall
        })
    }

    /// Begins anew with a value, which is no change: as when what the condition is about is exchanged. The counts go on.
    pub const fn restart(&mut self, is_set: bool) {
        self.is_set = is_set;
    }

    /// How often it rose.
    #[must_use]
    pub const fn rises(&self) -> u64 {
        self.rises
    }

    /// How often it fell.
    #[must_use]
    pub const fn falls(&self) -> u64 {
        self.falls
    }
}

/// Tells changes of a flag as an event.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Monitor {
    /// Which changes it tells.
    pub edge: Edge,
    /// The event that tells of them.
    pub event: EventId,
}

impl Monitor {
    /// A monitor that tells of a flag's rise.
    #[must_use]
    pub const fn on_rise(event: EventId) -> Self {
        Self {
            edge: Edge::Rise,
            event,
        }
    }

    /// The event, if it tells of such a change. Real time.
    #[must_use]
    pub fn event_of(&self, change: Change) -> Option<EventId> {
        let tells = match self.edge {
            Edge::Rise => change == Change::Rise,
            Edge::Fall => change == Change::Fall,
            Edge::Either => true,
        };
        tells.then_some(self.event)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_a_change_is_one() {
        let mut flag = Flag::new(true);
        assert_eq!(flag.set(true), None);
        assert_eq!(flag.set(false), Some(Change::Fall));
        assert_eq!(flag.set(false), None);
        assert_eq!(flag.set(true), Some(Change::Rise));
        flag.restart(false);
        assert!(!flag.is_set());
        assert_eq!(flag.set(true), Some(Change::Rise));
        assert_eq!((flag.rises(), flag.falls()), (2, 1));
    }

    #[test]
    fn a_monitor_tells_its_edges() {
        let told = |edge| {
            let monitor = Monitor {
                edge,
                event: EventId(7),
            };
            [Change::Rise, Change::Fall].map(|change| monitor.event_of(change).is_some())
        };
        assert_eq!(told(Edge::Rise), [true, false]);
        assert_eq!(told(Edge::Fall), [false, true]);
        assert_eq!(told(Edge::Either), [true, true]);
        assert_eq!(
            Monitor::on_rise(EventId(7)).event_of(Change::Rise),
            Some(EventId(7))
        );
    }
}
