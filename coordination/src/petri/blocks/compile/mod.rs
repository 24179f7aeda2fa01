//! From a checked model to the tables that an executor runs.

mod firings;
mod lay_out;
mod places;
mod tables;

pub(in crate::petri) use lay_out::compile;
