//! Acquire and release (the paper's Section 3.3): how a user gets a resource from its owner, and gives it back.
//!
//! ```text
//! user:   request                 [steps of use]    release
//! owner:            granted                                    [released]
//!                   [refused]     or the user gives it back unused: [returned]
//! ```
//!
//! An [`AcquireRelease`] declares such a protocol with names of its own; what is in brackets is left out unless it is declared.
//! [Compiled](AcquireRelease::compile), it is a [`Resource`]: a [`Protocol`](crate::protocol::Protocol) and what each of its positions means, its [`Phase`].
//! A protocol that was declared otherwise, as one with branches, is one if its paths [say so](Resource::of).
//! User and owner run it as any other protocol, each on its [`Side`](crate::protocol::Side): of a [`channel`](crate::protocol::channel) between
//! threads, or as [replicas](crate::protocol::Replica) on two machines.
//!
//! An owner that wants a resource back asks by a protocol of its own beside this one, a [`Revocation`], because nobody can set a
//! flag while it is the other's turn. Or it is the [keeper](AcquireRelease::keeper) and gives up the run.
//!
//! **Real time:** declaring and compiling allocate; asking for a phase looks it up.
//!
//! ```
//! use coordination::acquire_release::{AcquireRelease, Phase};
//! use coordination::protocol::{Change, Side, channel};
//!
//! let mut charger = AcquireRelease::new("charger", "robot", "station");
//! charger.acquire("ask", "granted").refuse("refused").release("gone");
//! let charger = charger.compile()?;
//! let flag = |name| charger.protocol().flag(name).expect("it is declared");
//! let (mut robot, mut station) = channel(charger.protocol());
//!
//! robot.set(flag("ask"))?;
//! assert_eq!(station.poll(), Some(Change::Flag(flag("ask"))));
//! assert_eq!(charger.phase(station.read_to()), Phase::Wanted);
//! station.set(flag("granted"))?;
//!
//! robot.poll();
//! assert!(charger.is_held(robot.read_to()));
//! robot.set(flag("gone"))?;
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod model;
mod resource;
mod revocation;

pub use model::{AcquireRelease, By, PatternError};
pub use resource::{OtherPath, Phase, Resource};
pub use revocation::Revocation;
