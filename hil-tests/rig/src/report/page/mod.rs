//! `report.html`: one file that needs nothing else, for people to look at.
//!
//! Paths are the world's truth, areas and their owners what an independent listener heard, firings the mediator's own
//! word. Each robot has one colour throughout. The page reads in light, in dark and on paper; however long the run
//! was, it stays under `LARGEST_BYTES`, because curves are thinned to what can be seen.

mod arcs;
mod floorplan;
mod frames;
mod headline;
mod html;
mod keys;
mod lanes;
mod layers;
mod net;
mod nets;
mod rows;
mod spacetime;
mod style;
mod tables;
mod timing;
mod view;
mod whole;

#[cfg(test)]
mod tests;

pub use whole::html;
