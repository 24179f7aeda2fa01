//! Analysis of a net before it may run: it visits every reachable state.
//!
//! A net alone is always dead or blocked: somebody must fill its sources and empty its sinks. So the
//! net is *closed* with the protocols it is bound to ([`Use`]): the other party of each protocol may
//! set any flag that is next, at any time, and in the end does; a sink bound to a flag is emptied
//! when the protocol lets its flag be set; a sink bound to an event is emptied at any time; a source
//! bound to an event may be filled whenever it is empty. Protocols begin between two runs, and a
//! complete run makes room for the next. A source bound to [`ABORTED`](crate::protocol::ABORTED)
//! is filled when the other party, if it is the protocol's keeper, gives up a run, and tokens in the
//! protocol's other sources and sinks are void. Until the net has dealt with that, nothing else of
//! the other party is read; so flags of the next run do not overtake the abort.
//!
//! [`check`] refuses a net, with the shortest sequence of steps that leads to the fault
//! ([`Refusal`]), unless
//! 1. every binding names a flag of a protocol in use, owned by the right party; and where the other
//!    party can give up, a source is bound to that, and each of its flags to at most one source;
//! 2. it is **safe**: no firing would put a second token into an internal place. The executor would
//!    not fire then, so nothing breaks; but a net that relies on full places to hold a transition
//!    back hides a condition that belongs into a place of its own. Full sinks may hold transitions
//!    back: that is how a net waits for its consumer;
//! 3. **exclusions** hold: never two of their places are marked;
//! 4. flags come **in order**: whenever a sink is marked, its flag is next, or only flags come before
//!    it whose sinks are marked too;
//! 5. it never **overflows**: no more than [`Limits::waiting`] events wait for a source;
//! 6. it never **stops** but in a declared end: the end's internal places are marked and no others,
//!    sinks and sources of flags are empty, and every protocol is between two runs. An event without
//!    protocol may have come after the end;
//! 7. **an end can be reached** from every state (no livelock), if the net declares ends; if it
//!    declares none, every run of every protocol that began can be completed;
//! 8. it is **not endless**: its transitions cannot fire for ever without a flag or event from outside,
//!    unless the net [allows it](crate::petri::NetModel::allow_endless);
//! 9. every transition fires in some state, so every sink is reached, and so is every end.
//!
//! Point 7 says that an end can be reached from wherever the net is, not that it will be. Between two
//! flags or events a net fires only finitely often (point 8), but robots could go around an end for ever,
//! and the executor's choice is fair only to transitions that stay enabled (see
//! [Fairness](crate::petri)). How long one party waits while others go on is not judged.
//!
//! What is found is a [`Proof`], which belongs to this net, its initial marking and its protocols.
//! [`NetBinding`](crate::binding::NetBinding) runs nets with a proof only.
//!
//! [Place invariants](place_invariants()) come first: what follows from arcs alone, safety of places and exclusions,
//! is not looked for any more, and is known even of a net that is too large for the rest.
//!
//! States are looked at one after another. With the feature `symbolic`, a net that has more of them than
//! [`Limits::states`] or more steps than [`Limits::steps`] is looked at as a set of states, in decision
//! diagrams with up to [`Limits::nodes`] nodes, and with the same result: a fault is one of the nearest,
//! and among equally near ones both searches name exclusions first, then the order of flags, then second
//! tokens, overflows and stops.
//!
//! [`properties`] answers what other tools for nets answer, whether a net may run or not: deadlock, reachable
//! markings, liveness of each transition.
//!
//! Not for real-time threads. Time and memory are bounded by [`Limits`]; a net that exceeds them is
//! refused, never passed.
//!
//! ```
//! use std::sync::Arc;
//! use coordination::analysis::{Limits, Use, check};
//! use coordination::petri::{Binding, NetModel};
//! use coordination::protocol::{Party, ProtocolModel};
//!
//! let mut ask = ProtocolModel::new("ask", "robot", "mediator");
//! ask.array("all", &[("request", "robot"), ("granted", "mediator"), ("left", "robot")]);
//! let uses = [Use::new("robot", Arc::new(ask.compile()?), Party::Second)];
//!
//! let mut gate = NetModel::new("gate");
//! gate.source("asked", Binding::flag("robot", "request"));
//! gate.sink("granted", Binding::flag("robot", "granted"));
//! gate.source("left", Binding::flag("robot", "left"));
//! gate.place("free").mark("free").place("taken").end("idle", &["free"]);
//! gate.transition("enter", &["asked", "free"], &["taken", "granted"]);
//! gate.transition("leave", &["left", "taken"], &[]);
//!
//! // "leave" does not give the token back.
//! let refusal = check(&gate, &uses, &Limits::default()).unwrap_err();
//! let way = refusal.trace.expect("it goes wrong on the way").to_string();
//! assert_eq!(
//!     way,
//!     "robot sets request; enter; mediator raises robot.granted; robot sets left; leave; \
//!      robot sets request"
//! );
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod check;
mod closed;
mod components;
mod explored;
mod findings;
pub(crate) mod flags;
mod graph;
mod invariants;
#[cfg(feature = "symbolic")]
mod kept;
mod liveness;
mod never;
mod proof;
mod properties;
mod refusal;
mod report;
mod state;
mod states;
mod store;
#[cfg(feature = "symbolic")]
mod symbolic;
mod usage;

pub use check::{check, check_situations};
pub use findings::Liveness;
pub use invariants::{PlaceInvariant, PlaceInvariants, place_invariants};
pub use proof::Proof;
pub use properties::{Marking, Properties, properties};
pub use refusal::{Dead, Reason, Refusal, Step, Trace};
pub use report::{ByInvariants, Report, Warning};
pub use usage::{Limits, Situation, Use};

#[cfg(test)]
mod random_nets;
