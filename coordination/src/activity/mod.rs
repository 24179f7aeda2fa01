//! Activities (the paper's Section 1.1): the smallest parts of a robot that run concurrently.
//!
//! Each has a [`LifeCycle`], a state machine that says which of its behaviours is active, and one
//! event loop in the order of the five Cs, [`event_loop_once`]. Many activities can share one
//! thread; none knows on which thread it runs.
//!
//! **Real time:** stepping a life cycle and running the loop do not allocate. In
//! [`LifeCycleState::Running`] an activity on a real-time thread keeps the real-time rules; in the
//! configuring states it may open ports, allocate and wait, with its outputs disabled.

mod event_loop;
mod life_cycle;

pub use event_loop::{Activity, event_loop_once};
pub use life_cycle::{LifeCycle, LifeCycleEvent, LifeCycleState};
