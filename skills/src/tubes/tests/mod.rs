//! Tests of the tubes against a small world of exact shapes.

mod adapting;
mod corridor;
mod driving;
mod fuzz;
mod generation;
mod guarantee;
mod remembering;
mod stand;
mod standing;
mod world;
