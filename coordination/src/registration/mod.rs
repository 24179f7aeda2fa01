//! Registration: coordination objects that come and go at run time, under a semantic id.
//!
//! A [`Registry`] is the paper's table of registrations: semantic id (datatype and model, together
//! unique), the activity that owns the object, and the object itself, reached through a [`Handle`].
//! Each registration lives through a [life cycle](crate::activity::LifeCycle): it is created,
//! configured, run, paused, configured anew, stopped, and deleted. Room is bounded, and a handle to
//! what was deleted is refused for ever, even when its place is used again.
//!
//! What is registered is up to the caller; [`Mechanism`] is any of this library's own: a net, a
//! machine, a protocol, or a net bound to its protocols. Nets are analysed when they are configured,
//! and one that is refused never runs.
//!
//! **Real time:** creating, configuring, deleting and searching allocate or free. Finding a running
//! object by its handle, running and pausing take constant time and do not, unless they are refused.
//!
//! ```
//! use coordination::activity::LifeCycleState;
//! use coordination::registration::{Registry, SemanticId};
//!
//! let mut registry = Registry::new(8);
//! let id = SemanticId::new("counter", "left");
//! let handle = registry.create(id.clone(), "area manager")?;
//! registry.configure(handle, |_| Ok::<u32, ()>(40)).expect("it is there");
//! registry.run(handle)?;
//! *registry.running(handle)? += 2;
//! assert_eq!(registry.get(handle)?.object, Some(&42));
//!
//! registry.stop(handle)?;
//! assert_eq!(registry.get(handle)?.state, LifeCycleState::Stopped);
//! assert_eq!(registry.delete(handle)?, Some(42));
//! assert!(registry.get(handle).is_err());
//! # Ok::<(), coordination::registration::RegistryError>(())
//! ```

mod error;
mod mechanism;
mod registry;
mod semantic_id;

pub use error::{ConfigureError, RegistryError};
pub use mechanism::{Mechanism, MechanismError};
pub use registry::{Handle, Registered, Registry};
pub use semantic_id::SemanticId;
