//! Checks a model and puts numbers in the place of names.

mod arcs;
mod declarations;
mod errors;
mod resolve;

pub(in crate::petri) use declarations::{MAX_ARCS, MAX_PLACES, MAX_TRANSITIONS};
pub(in crate::petri) use resolve::resolve;
