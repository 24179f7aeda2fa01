//! Tests that start whole robots or their devices as processes: one binary, so that the programs' libraries are linked once.

mod bad_days;
mod bench;
mod figures;
mod fleets;
mod held;
mod late;
mod stranger;
mod turn;
