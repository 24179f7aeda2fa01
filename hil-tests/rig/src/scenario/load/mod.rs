//! From a scenario file to a scenario.

mod file;
mod reader;
mod source;

pub use source::{Changes, load, load_shipped};
