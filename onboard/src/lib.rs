//! The robot's process: five real-time threads, seven activities, and the supervisor that looks after them.

pub mod rt;
