//! The rig's own processes: robots, the mediator, and what cleans up after them.

mod child;
pub mod janitor;
pub mod mediator;
pub mod robot;
pub mod usage;

pub use child::{Process, log_tail};
pub use usage::Usage;
