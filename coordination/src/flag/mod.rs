//! Flags (the paper's Section 1.2): Boolean conditions over the data of an activity, and the events that their changes are.
//!
//! A [`Flag`] is one condition. Whoever evaluates the condition [sets](Flag::set) it, as often as it likes; what comes back is the
//! [`Change`], if there is one. A [`Monitor`] turns a rise, a fall, or either into an event for a machine, a net or a queue. What a
//! flag is at first is no change and so no event.
//!
//! [`Flags`] holds all flags of an activity by number, with any number of monitors on each; a [`FlagsModel`] names them. A flag
//! belongs to one activity. What two activities share is a symbol, or a flag of a [`protocol`](crate::protocol), which also says
//! whose turn it is to set it.
//!
//! **Real time:** nothing here allocates, locks or makes a system call but building a model and compiling it.
//!
//! ```
//! use coordination::event::EventTable;
//! use coordination::flag::{Change, Edge, FlagsModel};
//!
//! let mut model = FlagsModel::new("lidar");
//! model.flag("blocked", false).monitor("blocked", Edge::Rise, "stop").monitor("blocked", Edge::Fall, "go");
//! let mut events = EventTable::new();
//! let mut flags = model.compile(&mut events)?;
//! let blocked = flags.find("blocked").expect("the model has it");
//!
//! let (near_m, mut fired) = (0.3, Vec::new());
//! for distance_m in [1.0, 0.2, 0.1, 0.8] {
//!     let changed = flags.set(blocked, distance_m < near_m);
//!     fired.extend(changed.events().map(|event| events.name(event).expect("of this table")));
//! }
//! assert_eq!(fired, ["stop", "go"]);
//! assert_eq!(flags.get(blocked).expect("it is of these flags").rises(), 1);
//! # Ok::<(), coordination::flag::FlagsError>(())
//! ```

mod condition;
mod set;

pub use condition::{Change, Edge, Flag, Monitor};
pub use set::{Changed, FlagIndex, Flags, FlagsError, FlagsModel};
