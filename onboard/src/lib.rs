//! The robot's process: five threads, seven activities, and the supervisor that looks after them.
//!
//! | part | does |
//! |---|---|
//! | [`cli`], [`check`], [`run`], [`inspect`], [`ctl`] | the commands of the program |
//! | [`plan`] | the two files, checked, and made into parts |
//! | [`wiring`], [`values`] | the symbols: what is shared, who owns it, who reads it |
//! | [`activities`], [`port`] | the activities, their life cycles and queues |
//! | [`fleet`] | the robot's side of the mediator, without network and threads |
//! | [`runner`], [`asynchronous`], [`rt`] | threads: triggers, scheduling, measurement, real-time rules |
//! | [`supervisor`], [`faults`], [`overruns`], [`reload`], [`log`](mod@log) | life cycles, faults, requests, log |
//!
//! Data flows in one circle: drive → encoders → proprioception → odometry → navigation → wanted command → motion tube →
//! safe command → control → wheel setpoints → drive; the lidar's scan enters at navigation and motion tube.

pub mod activities;
pub mod asynchronous;
pub mod check;
pub mod cli;
pub mod compose;
pub mod ctl;
pub mod faults;
pub mod fleet;
pub mod inspect;
pub mod log;
pub mod overruns;
pub mod panic;
pub mod plan;
pub mod port;
pub mod reload;
pub mod rt;
pub mod run;
pub mod runner;
pub mod runtime;
mod site_parts;
pub mod supervisor;
pub mod values;
pub mod wiring;

pub use cli::main_from;
