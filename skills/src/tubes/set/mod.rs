//! A set of tubes: made once, then only read.
//!
//! * `border`: the border of one tube as a list of points;
//! * `generate`: samples to beams, what memory must answer for, what is refused and why;
//! * [`report`]: what was generated, and what was refused;
//! * [`tube_set`]: the flat arrays and their evaluation; [`brute_force`]: what that is measured against.

mod border;
pub mod brute_force;
mod generate;
pub mod report;
pub mod tube_set;
