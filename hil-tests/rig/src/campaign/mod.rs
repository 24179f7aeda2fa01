//! A scenario many times, with one seed after the other: each run a process of its own, or on the simulated clock.

pub mod agreement;
mod cases;
pub mod faults;
mod ledger;
mod pool;
pub mod processes;
pub mod shrink;
pub mod statistics;
pub mod stepped;
