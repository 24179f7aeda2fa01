//! The command line.

mod check;
mod commands;
mod failure;
mod files;
mod keys;
mod network;
mod run;
mod status;
mod which;

pub use commands::main_from;
pub use failure::{EXIT_FAILED, EXIT_REFUSED, EXIT_UNDECIDED};
