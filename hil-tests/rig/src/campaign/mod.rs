//! A scenario many times, with one seed after the other: each run a process of its own, or on the simulated clock.

pub mod agreement;
mod cases;
mod expected;
pub mod faults;
mod ledger;
mod once;
mod pool;
pub mod processes;
pub mod shrink;
mod spread;
pub mod statistics;
pub mod stepped;
