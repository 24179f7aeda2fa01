//! Mechanisms of runtime coordination, with no robot, device or network in them, after Artigas, Rodrigues, Vanderseypen and
//! Bruyninckx, *Software patterns and data structures for the runtime coordination of robots*, Frontiers in Robotics and AI
//! (2024): "the paper" everywhere here.
//!
//! * [`analysis`]: what is proved of a net before it may run;
//! * [`event`]: dense event ids and bounded, wait-free queues of events;
//! * [`fsm`]: Mealy machines, from a symbolic model to dense tables;
//! * [`petri`]: Petri nets, from a symbolic model to dense tables that an executor runs;
//! * [`protocol`]: flag arrays, the order in which two parties set the flags that they share;
//! * [`binding`]: nets and protocols together;
//! * [`activity`]: the life cycle of an activity and the 5C event loop;
//! * `symbols` (feature `symbols`): the symbol table in shared memory.
//!
//! **Real time.** What is built once (tables, queues, machines) may allocate while it is built;
//! using it afterwards never allocates, locks, logs, waits or makes a system call. Where a function
//! is not for a real-time thread, its documentation says so.

pub mod activity;
pub mod analysis;
pub mod binding;
pub mod event;
pub mod fsm;
pub mod petri;
pub mod protocol;
#[cfg(feature = "symbols")]
pub mod symbols;

/// The examples of the README are tests.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
