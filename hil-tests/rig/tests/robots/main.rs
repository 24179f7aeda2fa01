//! Tests that start whole robots or their devices as processes: one binary, so that the programs' libraries are linked once.

mod bad_days;
mod bench;
mod fleets;
mod late;
mod stranger;
mod turn;
