//! Tests that start whole robots as processes, one after the other: one binary, so that the programs' libraries are linked
//! once.

mod bad_days;
mod fleets;
mod turn;
