//! The process around the activities: threads, supervisor, control socket, and views from outside.

pub mod asynchronous;
#[cfg(test)]
mod bench;
pub mod checkpoints;
pub mod ctl;
pub mod inspect;
pub mod overruns;
pub mod reload;
pub mod run;
pub mod runner;
pub mod runtime;
pub mod signals;
pub mod supervisor;
pub mod teleop;
pub mod wakes;
mod watchdogs;
