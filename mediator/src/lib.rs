//! The area manager: which robot may be in which area, and who goes first.
//!
//! * [`cli`]: the commands of the program;
//! * [`setup`]: the areas and robots of one site;
//! * [`nets`]: Petri nets between robots, started by the situation;
//! * [`manager`]: the manager itself, pure: reports in, journal entries and reports out, no clock, network or file;
//! * [`journal`]: what survives a restart;
//! * [`runtime`]: the running mediator, on the fleet's network.
//!
//! A step is always the same: hand in what arrived, write the entries to the journal, and only then send the messages.
//! So whatever a robot was told, the next start of the mediator knows.

pub mod cli;
mod jam;
pub mod journal;
pub mod manager;
pub mod nets;
pub mod runtime;
pub mod setup;
mod site;

pub use cli::main_from;
