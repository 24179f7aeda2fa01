//! Petri nets: the decisions that coordinate several activities.
//!
//! A [`NetModel`] names places, transitions and arcs, and what each source and sink is bound to;
//! [`NetModel::compile`] checks it and makes a [`Net`] of dense tables; an [`Executor`] runs it.
//! Many executors may share one net.
//!
//! **Semantics.** A place holds at most one token (Murata's capacity one). A transition is enabled
//! when all its inputs are marked and all its outputs, other than its own inputs, are empty. So a
//! full place delays who would fill it, and a full sink waits for its consumer. An event for a full
//! source waits, counted, and fills the source at the beginning of a later evaluation.
//!
//! **Choice.** Of the enabled transitions the first in the order of declaration fires, starting
//! behind the one that fired last and wrapping around, across evaluations; the same offers give the
//! same firings.
//!
//! **Budget.** An evaluation fires at most [`Budget::firings`] times and lasts at most
//! [`Budget::rounds`] rounds. In one round each transition fires at most once; the next round
//! begins when no enabled transition is left that has not fired in this one. What is left waits
//! for the next evaluation. In nets of more than 2,048 transitions the search for the next enabled one
//! is limited too ([`Executor::limit_search`]): then an evaluation may end before its budget does,
//! and says that something remains.
//!
//! **Fairness.** While a transition stays enabled and does not fire, every other one fires at most
//! twice; at most once if all evaluations have the budget [`Budget::ONE`]. For the search goes around
//! all transitions and passes over none that is enabled and has not fired in this round. So, from the
//! moment when that holds of a transition, each other one can fire once; on its way to a second time the
//! search comes to the one that waits. Only one that has fired in this round already, and is enabled
//! again, has to wait for the next round, before which each other one can fire once more. An evaluation
//! that ends within a round ends the round too. Nothing is promised to a transition that is enabled only
//! now and then: an unlucky rhythm of the others may miss it for ever.
//!
//! **In the paper's words** (Section 4.1, Figure 4). What its executor keeps in lists is here in
//! words of bits: `masks` explains those of most nets, `blocks` those of very large ones.
//!
//! | paper | here |
//! |---|---|
//! | `place_to_transitions`, `transition_input_place`, `transition_output_place` | per transition, a mask of the places that it asks for, their marks while it is enabled, those that it changes, and the transitions that may be enabled then |
//! | `sink_places`, `sink_to_events`, `sink_index` | the net's ports: full sinks in the order in which they filled, each with its event |
//! | `marking` | a bit for each place |
//! | `places_to_process`, `transitions_to_fire` and what is in them already | the set of transitions to look at |
//! | `places_to_skip` | the same set: what is left in it is looked at in the next evaluation |
//! | `marking_history`, `max_number_of_loops` | which transitions have fired in this round, and [`Budget::rounds`]; counted per transition, since a shared resource is passed on many times in one round |
//!
//! **Real time:** everything that an [`Executor`] does after it was made is bounded by what it
//! touches, not by the size of the net, and does not allocate; its documentation names the
//! exceptions. Building and compiling a model allocate.
//!
//! ```
//! use coordination::event::EventTable;
//! use coordination::petri::{Binding, Budget, NetModel};
//!
//! let mut model = NetModel::new("gate");
//! model.source("asked", Binding::event("ask")).sink("granted", Binding::event("grant"));
//! model.place("free").mark("free").place("taken");
//! model.source("left", Binding::event("leave"));
//! model.transition("enter", &["asked", "free"], &["taken", "granted"]);
//! model.transition("leave", &["left", "taken"], &["free"]);
//!
//! let mut events = EventTable::new();
//! let net = model.compile(&mut events).expect("the model is sound");
//! let mut gate = net.executor();
//! gate.offer(events.id("ask").expect("the net uses it")).expect("nothing waits yet");
//! let evaluation = gate.evaluate(Budget::default());
//! assert_eq!((evaluation.fired, evaluation.remaining), (1, false));
//! let mut granted = Vec::new();
//! gate.drain_sinks(|event| {
//!     granted.push(event);
//!     true
//! });
//! assert_eq!(granted, [events.id("grant").expect("the net uses it")]);
//! ```

mod bits;
mod blocks;
mod by_hand;
mod demand;
mod dot;
mod engine;
mod evaluation;
mod executor;
mod id;
mod masks;
mod model;
mod net;
mod ports;
mod span;

pub use by_hand::Obstacle;
pub use dot::Dot;
pub use evaluation::{Budget, Evaluation};
pub use executor::{Executor, OfferError, WrongMarking};
pub use id::{PlaceId, TransitionId};
pub use model::{Binding, ModelError, NetModel, Place, PlaceKind, PlaceSet, Structure, Transition};
pub use net::Net;
