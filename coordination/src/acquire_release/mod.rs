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
//! A [`User`] and an [`Owner`] are the two roles on a [`Side`](crate::protocol::Side), whatever connects it to the other side: a
//! [`channel`](crate::protocol::channel) between threads, or [replicas](crate::protocol::Replica) between machines.
//!
//! An owner that wants a resource back asks by a protocol of its own beside this one, a [`Revocation`], because nobody can set a
//! flag while it is the other's turn. Or it is the [keeper](AcquireRelease::keeper) and gives up the run.
//!
//! **Real time:** declaring and compiling allocate; the roles do what their side does, without allocating.
//!
//! ```
//! use coordination::acquire_release::{AcquireRelease, Owner, Phase, User};
//! use coordination::protocol::channel;
//!
//! let mut charger = AcquireRelease::new("charger", "robot", "station");
//! charger.acquire("ask", "granted").refuse("refused").release("gone");
//! let charger = charger.compile()?;
//! let (mut robot, mut station) = channel(charger.protocol());
//!
//! User::new(&charger, &mut robot)?.request()?;
//! let mut owner = Owner::new(&charger, &mut station)?;
//! owner.read(|_| {});
//! assert!(owner.may_grant());
//! owner.grant()?;
//!
//! let mut user = User::new(&charger, &mut robot)?;
//! user.read(|_| {});
//! assert_eq!(user.phase(), Phase::Held);
//! user.release()?;
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod model;
mod resource;
mod revocation;
mod roles;

pub use model::{AcquireRelease, By, PatternError};
pub use resource::{Phase, Resource};
pub use revocation::Revocation;
pub use roles::{NotDeclared, Owner, RoleError, User, WrongSide};
