//! The skills together, in simulated worlds; judged by what is true there.

mod allocations;
mod closed_loop;
mod clutter;
mod localisation;
mod plant;
mod random;
