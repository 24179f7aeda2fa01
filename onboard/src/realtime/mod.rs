//! What a real-time thread stands on: time, scheduling, memory, measurement, and the guards that prove the rules.
//!
//! Contract: after a thread is promoted, nothing in [`clock`], [`histogram`], [`wake`] or [`guard`] allocates, locks or logs.

pub mod clock;
pub mod guard;
pub mod histogram;
pub mod latency;
pub mod log;
pub mod memory;
pub mod own_cores;
pub mod panic;
pub mod scheduling;
pub mod system_calls;
pub mod wake;
