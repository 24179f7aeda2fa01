//! The skills together, in simulated worlds; judged by what is true there.

mod closed_loop;
mod clutter;
#[path = "../../../coordination/tests/counting/mod.rs"]
mod counting;
mod localisation;
mod plant;
mod random;
