//! From a checked model to the tables that an executor runs.

mod conditions;
mod firings;
mod lay_out;
mod tables;

pub(super) use lay_out::compile;
