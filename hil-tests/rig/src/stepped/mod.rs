//! Robots on a simulated clock: no threads, no devices, and much faster than real time (a core steps fleets about 60 times
//! as fast).
//!
//! All seven activities run, but for communication where the rig withholds leave for areas (`withhold_areas` of a scenario, as in
//! `course`): `leave` stands in for it there. They run in the event loops that the robot's threads run, with their symbols between them
//! and their supervisor: each thread of the thread table is a coroutine (`thread`) that waits on its own simulated clock. EtherCAT frames
//! are exchanged with the simulated segment (`bus`), SCIP with the simulated sensor (`lidar`), byte for byte, both in memory.
//! The mediator's area management runs with its journal, as on its own thread.
//!
//! What does not run:
//! - zenoh, for which `network` carries the same messages, and with it the mediator's network and control socket: its thread of
//!   communication, with which it renews certificates and opens its network anew;
//! - tokio, whose one loop is stepped: when it runs is decided as on its thread, and the thread that passes wake-ups on is one call;
//! - of threads beside those of the thread table: those that write log lines and checkpoints, that serve the control socket and the
//!   desk of who drives by hand (`desk` stands in for it), and that feed systemd's watchdog and the
//!   computer's: nobody restarts what hangs here, until its fault is over. A reload's files are read while time stands;
//! - the kernel's scheduler, network stack and terminals (computing takes no time here); the disk below the journal, which is memory;
//! - the hook of panics, which is the whole process's: where a thread panics, its event loop says so to its robot alone (`panics`).
//!
//! [`Stepped`] runs the robots of a scenario this way, for [`Run`](crate::run::Run) to judge; [`SteppedRobot`] is one robot.
//!
//! The same seed gives the same run. [`faults`] come from the scenario or are drawn from the seed.

mod apart;
mod asking;
mod asynchronous;
mod bus;
mod checkpoints;
mod clearing;
mod clock;
mod clones;
mod closing;
mod desk;
mod devices;
mod disk;
mod disturbing;
mod driving_out;
mod execution;
pub mod faults;
mod fleet;
mod injection;
mod late;
mod leave;
mod lidar;
mod mediating;
mod mediator;
mod member;
mod message;
mod motors_off;
mod network;
mod operated;
mod panics;
mod plans;
mod processes;
mod reloading;
mod requests;
mod restarting;
mod robot;
mod running;
mod sending_on;
mod split;
mod start;
mod thread;
mod to_end;
mod trace;
pub mod work;

pub use checkpoints::Checkpoints;
pub use desk::SteppedDesk;
pub use devices::Devices;
pub use fleet::Stepped;
pub use plans::Plans;
pub use robot::SteppedRobot;
pub use start::{Fleet, Start};
pub use trace::{Trace, Traces};
