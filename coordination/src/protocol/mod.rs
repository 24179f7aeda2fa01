//! Protocol flag arrays (the paper's Section 3.2): the order in which two parties may set the flags
//! that they share.
//!
//! A [`ProtocolModel`] lists entries, each a flag and the party that may set it, in arrays; an array
//! can be followed by one of several others, so that a run can take one of several paths. Compiled,
//! it is a [`Protocol`]: a tree of positions, of which each is "these flags are set, in this order".
//!
//! A run begins with an empty array and sets entries strictly from the first on. A party that sets
//! another's flag, or one out of order, gets an error and changes nothing. Before it sets a flag, a
//! party must have read ([`poll`](Side::poll)) all that the other has set.
//!
//! **Who empties the array.** The party that did *not* set the last flag empties it, by reading that
//! flag; so a new run begins only when both have seen the whole of the last one, and no poll can miss
//! or repeat a flag however the threads interleave. At every moment exactly one party may write: the
//! owner of the next flag, or at the end the reader. The one exception is the *keeper*, if the model
//! declares one: it may [abort](End::abort) a run at any time, which empties the array and begins the
//! next run. The other party then reads [`Change::Aborted`] in place of what it had not read.
//!
//! **Run numbers** count up by one with every run and never wrap: when run [`u32::MAX`] has ended,
//! setting a flag is refused with [`SetError::Exhausted`].
//!
//! Two threads share a protocol through the two [`End`]s of a [`channel`]. Two machines each hold a
//! [`Replica`] and send each other its [`Level`], as often as they like: a level that is repeated,
//! late or out of order changes nothing, and the next one makes up for a lost one. Both are a
//! [`Side`], and either is an [`AnySide`].
//!
//! **Real time:** building and compiling a model allocates. Setting, polling and aborting do not
//! allocate or wait; an [`End`] is wait-free.
//!
//! ```
//! use std::sync::Arc;
//! use coordination::protocol::{Change, ProtocolModel, Side, channel};
//!
//! let mut model = ProtocolModel::new("crossing", "robot", "mediator");
//! model.array("ask", &[("request", "robot")]);
//! model.array("yes", &[("granted", "mediator"), ("entered", "robot"), ("released", "robot")]);
//! model.array("no", &[("refused", "mediator")]);
//! model.follow("ask", "yes").follow("ask", "no");
//! let protocol = Arc::new(model.compile()?);
//!
//! let (mut robot, mut mediator) = channel(&protocol);
//! let flag = |name| protocol.flag(name).expect("the model has it");
//! robot.set(flag("request"))?;
//! assert_eq!(mediator.poll(), Some(Change::Flag(flag("request"))));
//! mediator.set(flag("refused"))?;
//! assert_eq!(robot.poll(), Some(Change::Flag(flag("refused"))));
//! robot.set(flag("request"))?; // the next run
//! assert_eq!(robot.run(), 1);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

#[cfg(target_has_atomic = "64")]
mod any_side;
#[cfg(target_has_atomic = "64")]
mod channel;
mod cursor;
mod error;
mod graph;
mod level;
mod model;
mod replica;
#[cfg(target_has_atomic = "64")]
mod sync;
mod tree;

#[cfg(target_has_atomic = "64")]
pub use any_side::AnySide;
#[cfg(target_has_atomic = "64")]
pub use channel::{End, channel, channel_at};
pub use cursor::{AbortError, Change, SetError, Side};
pub use error::{ModelError, Problem};
pub use level::Level;
pub use model::ProtocolModel;
pub use replica::{MergeError, Merged, Replica, RunNotNewer};
pub use tree::{ABORTED, FlagId, Party, Position, Protocol};
