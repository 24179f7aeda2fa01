//! The robot's process: five threads, seven activities, and the supervisor that looks after them.
//!
//! Levels, each using only those above it in this table:
//!
//! | level | holds |
//! |---|---|
//! | [`realtime`] | clock, scheduling, memory, allocation guard, histograms, wake-ups, panic flag, log queue |
//! | [`symbols`] | what is shared between activities: values, faults, who owns and who reads each |
//! | [`fleet`] | the robot's side of the mediator, without network and threads |
//! | [`activities`] | the seven activities, their ports, life cycles and queues |
//! | [`composition`] | the two files, checked, made into parts and activities |
//! | [`process`] | threads, supervisor, control socket, reload, views from outside |
//! | [`cli`] | the commands of the program |
//!
//! Data flows in one circle: drive → encoders → proprioception → odometry → navigation → wanted command → motion tube →
//! safe command → control → wheel setpoints → drive; the lidar's scan enters at navigation and motion tube.

pub mod activities;
pub mod cli;
pub mod composition;
pub mod fleet;
pub mod process;
pub mod realtime;
pub mod symbols;

pub use cli::main_from;
