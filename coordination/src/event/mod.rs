//! Events (the paper's Section 1.2): what happened, as small numbers, and the queues that carry
//! them between activities.
//!
//! An [`EventTable`] gives each event name a dense [`EventId`], so that machines and nets can use
//! arrays instead of searching. A [`queue`] carries events from exactly one producer to exactly one
//! consumer. A full queue refuses the event, gives it back and counts it: no event disappears
//! unseen.
//!
//! **Real time:** [`Sender::send`] and [`Receiver::receive`] are wait-free and do not allocate.
//! Building a table or a queue allocates.
//!
//! ```
//! use coordination::event::{EventTable, queue};
//!
//! let mut events = EventTable::new();
//! let done = events.intern("done")?;
//! let (mut sender, mut receiver) = queue(8);
//! sender.send(done).expect("an empty queue takes an event");
//! assert_eq!(receiver.receive().map(|event| events.name(event)), Some(Some("done")));
//! # Ok::<(), coordination::event::TooManyEvents>(())
//! ```

#[cfg(target_has_atomic = "64")]
mod queue;
mod table;

#[cfg(target_has_atomic = "64")]
pub use queue::{QueueFull, Receiver, Sender, queue};
pub use table::{EventId, EventTable, TooManyEvents};
