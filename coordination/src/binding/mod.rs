//! Nets, machines and protocols together (the paper's Figure 3): how the events of one activity
//! become the tokens of another.
//!
//! An output event of a robot's machine sets a flag of a protocol; the flag fills a source of the
//! mediator's net; a transition fires and marks a sink; the sink sets the mediator's flag; that
//! becomes an input event of the machine. [`NetBinding`] is the mediator's half, with one protocol
//! side per robot; [`MachineBinding`] is the robot's half, with one side per protocol that it takes
//! part in. What is proved is what runs: a net is bound with the [`Proof`](crate::analysis::Proof) that its
//! [analysis](crate::analysis) has found, in a state that the proof reaches, and the state of a binding
//! is the analysis's: a marking, events that wait, positions of protocols. The sides are [`End`](crate::protocol::End)s or [`Replica`](crate::protocol::Replica)s.
//!
//! `examples/t_junction.rs` shows it whole: three robots and a mediator, each on its own thread.
//!
//! A flag is known to nets and machines as the event `<protocol>.<flag>`, where `<protocol>` is the
//! name that the side was given here; a run that the other party aborted is `<protocol>.aborted`.
//!
//! **Nothing is lost.** A sink is emptied only when the protocol has taken its flag, and an output
//! flag of a machine waits in order until then. A flag for a full source waits, counted; a flag with
//! several sources waits for each of them by itself, so that one that is full holds nothing back from
//! another. A flag that the machine's present state has no transition for stays unread until it has one, so that the
//! protocol, not luck, decides the order; a flag that the net or the machine is not bound to at all
//! is read and has no effect. All waiting is bounded: what finds no room stays unread, or is given
//! back to the caller.
//!
//! **An abort** by the other party voids what belongs to the run: tokens in the sources and sinks of
//! that protocol, flags that wait to be set. Nothing behind the abort is read before the net's
//! transitions have taken it from its source, or the machine has stepped for it. What the net or machine
//! does about it is up to its transitions on `<protocol>.aborted`.
//!
//! **Real time:** making a binding allocates; using it does not, and every call does a bounded
//! amount of work.

mod error;
mod machine;
mod net;
mod proved;
mod wiring;

pub use error::BindError;
pub use machine::{MachineBinding, NoRoom, Stuck};
pub use net::{NetBinding, Progress};
pub use proved::Standing;
