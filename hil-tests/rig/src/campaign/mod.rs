//! Many runs.

pub mod processes;
pub mod statistics;
