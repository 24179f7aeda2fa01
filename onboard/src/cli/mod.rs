//! The command line.

mod arguments;
mod check;
mod doctor;
mod teleop;

pub use crate::composition::failure::{EXIT_FAILED, EXIT_REFUSED, Failure};
pub use crate::composition::files::{Files, overrides};
pub use arguments::main_from;
