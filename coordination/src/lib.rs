//! Mechanisms of runtime coordination, with no robot, device or network in them, after Artigas, Rodrigues, Vanderseypen and
//! Bruyninckx, *Software patterns and data structures for the runtime coordination of robots*, Frontiers in Robotics and AI
//! (2024): "the paper" everywhere here.
//!
//! * [`acquire_release`]: the protocol by which a resource is acquired from its owner and released;
//! * `analysis` (feature `analysis`, on by default): what is proved of a net before it may run; large nets with the feature `symbolic`;
//! * [`event`]: dense event ids and bounded, wait-free queues of events;
//! * [`flag`]: Boolean conditions, whose changes are events;
//! * [`fsm`]: Mealy machines, from a symbolic model to dense tables;
//! * [`petri`]: Petri nets, from a symbolic model to dense tables that an executor runs;
//! * [`protocol`]: flag arrays, the order in which two parties set the flags that they share;
//! * `binding` (the same feature): nets and protocols together;
//! * [`activity`]: the life cycle of an activity and the 5C event loop;
//! * `pnml` (feature `pnml`): nets of other tools, and ours for them;
//! * `symbols` (feature `symbols`): the symbol table in shared memory.
//!
//! # Example
//! A robot asks for an area. Its side and the mediator's are on two machines, and send each other levels, as often as they like;
//! the grant is an event for the robot's machine.
//! ```
//! use std::sync::Arc;
//! use coordination::event::EventTable;
//! use coordination::fsm::MachineModel;
//! use coordination::protocol::{Change, Party, ProtocolModel, Replica, Side};
//!
//! let mut area = ProtocolModel::new("area", "robot", "mediator");
//! area.array("pass", &[("request", "robot"), ("granted", "mediator"), ("released", "robot")]);
//! let area = Arc::new(area.compile()?);
//! let flag = |name| area.flag(name).expect("listed above");
//! let mut robot = Replica::new(&area, 0, Party::First, 0);
//! let mut mediator = Replica::new(&area, 0, Party::Second, 0);
//!
//! let mut machine = MachineModel::new("robot");
//! machine.state("waiting").state("inside").initial("waiting");
//! machine.transition("waiting", "granted", "inside", &["drive"]);
//! let mut machine = machine.compile(&mut EventTable::new())?;
//!
//! robot.set(flag("request"))?;
//! mediator.merge(robot.level())?;
//! assert_eq!(mediator.poll(), Some(Change::Flag(flag("request"))));
//! mediator.set(flag("granted"))?;
//! robot.merge(mediator.level())?;
//! if let Some(Change::Flag(flag)) = robot.poll()
//!     && let Some(event) = machine.input(area.flag_name(flag))
//! {
//!     machine.step(event);
//! }
//! assert_eq!(machine.state_name(machine.state()), "inside");
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! Without default features it needs an allocator and no `std`.
//!
//! **Real time.** What is built once (tables, queues, machines) may allocate while it is built;
//! using it afterwards never allocates, locks, logs, waits or makes a system call. Where a function
//! is not for a real-time thread, its documentation says so.

#![cfg_attr(not(any(feature = "std", test)), no_std)]

extern crate alloc;

pub mod acquire_release;
pub mod activity;
#[cfg(feature = "analysis")]
pub mod analysis;
#[cfg(feature = "analysis")]
pub mod binding;
pub mod event;
pub mod flag;
pub mod fsm;
mod listed;
pub mod petri;
#[cfg(feature = "pnml")]
pub mod pnml;
pub mod protocol;
#[cfg(feature = "symbols")]
pub mod symbols;

/// The examples of the README are tests.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
