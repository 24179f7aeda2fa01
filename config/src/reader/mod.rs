//! Reads typed values out of the tree and collects every problem on the way.
//!
//! A value that is missing or wrong is reported and replaced by a placeholder (NaN, 0, empty), so that reading goes on;
//! a file with problems never becomes a configuration. Keys that nothing has read by the end of a table are reported as
//! unknown.

mod section;
mod source;
mod values;

pub(crate) use section::Section;
