//! Finite state machines (the paper's Section 3.1): the discrete behaviour of one activity.
//!
//! A machine is a Mealy machine (S, I, O, T, O): states, input events, output events, and for a
//! state and an input at most one next state with its outputs. It is in exactly one state. A
//! [`MachineModel`] names these things; [`MachineModel::compile`] checks it and makes a [`Machine`]
//! of dense tables that reads and fires the events of one [`EventTable`](crate::event::EventTable).
//!
//! An input without a transition in the present state is ignored and counted, never an error,
//! because a machine cannot decide which events arrive.
//!
//! [`Machine::to_net`] makes the equivalent Petri net (the paper's Figure 2), and [`MachineModel::of_net`]
//! the machine of a small net.
//!
//! **Real time:** [`Machine::step`] takes constant time and does not allocate. Building a model and
//! compiling it allocate.
//!
//! ```
//! use coordination::{event::EventTable, fsm::MachineModel};
//!
//! let mut model = MachineModel::new("door");
//! model.state("closed").state("open").initial("closed");
//! model.transition("closed", "push", "open", &["light_on"]);
//! model.transition("open", "pull", "closed", &["light_off"]);
//!
//! let mut events = EventTable::new();
//! let mut door = model.compile(&mut events)?;
//! let push = events.id("push").expect("the model uses it");
//! let step = door.step(push);
//! assert!(!step.ignored);
//! assert_eq!(step.outputs, [events.id("light_on").expect("the model uses it")]);
//! assert_eq!(door.state_name(door.state()), "open");
//! assert!(door.step(push).ignored);
//! # Ok::<(), coordination::fsm::ModelError>(())
//! ```

mod machine;
mod model;
mod net;
mod of_net;

pub use machine::{Machine, OutputId, StateId, Step, Transition};
pub use model::{MachineModel, ModelError};
pub use of_net::{OfNetError, OfNetLimits, Unused};

#[cfg(test)]
mod tests;
