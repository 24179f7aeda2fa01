//! Nets and protocols together: how the events of one activity become the tokens of another.
//!
//! A flag of the other party fills a source of the net; a transition fires and marks a sink; the sink sets this party's flag.
//! A [`NetBinding`] is the mediator's half, with one protocol side per robot; a robot sets and reads its flags by itself.
//! What is proved is what runs: a net is bound with the [`Proof`](crate::analysis::Proof) that its
//! [analysis](crate::analysis) has found, in a state that the proof reaches, and the state of a binding is the analysis's: a
//! marking, events that wait, positions of protocols. The sides are [`End`](crate::protocol::End)s or
//! [`Replica`](crate::protocol::Replica)s, or of both kinds as [`AnySide`](crate::protocol::AnySide)s.
//!
//! `examples/t_junction.rs` shows it whole: three robots and a mediator, each on its own thread.
//!
//! A net names flags by the name that their side was given here; a run that the other party aborted is the flag `aborted`.
//!
//! **Nothing is lost.** A sink is emptied only when the protocol has taken its flag. A flag for a full source waits, counted;
//! a flag with several sources waits for each of them by itself, so that one that is full holds nothing back from another. A
//! flag that the net is not bound to is read and has no effect. All waiting is bounded: what finds no room stays unread, or
//! is given back to the caller.
//!
//! **An abort** by the other party voids what belongs to the run: tokens in the sources and sinks of that protocol. Nothing
//! behind the abort is read before the net's transitions have taken it from its source.
//!
//! **Real time:** making a binding allocates; using it does not, and every call does a bounded
//! amount of work.

mod error;
mod net;
mod proved;
mod sides;
mod wiring;

pub use error::BindError;
pub use net::{NetBinding, Progress};
pub use proved::Standing;

#[cfg(test)]
mod tests;
