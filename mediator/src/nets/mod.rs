//! Coordinations: Petri nets that come and go while the mediator runs.
//!
//! A [`Plan`] says when a net starts on a site and what its flags mean there; it is made from the site file and the net
//! files, and no net gets into one that the analysis refuses. Two kinds of roles take part in nets: those whose protocol
//! begins with `acquire` give the discrete control of their robot away (protocol 2), for those whose protocol is request,
//! granted, entered, released the net decides when the robot is let into its areas (protocol 1).
//!
//! An instance is one run of a plan with certain robots: the net's marking, and this side of each protocol. It is pure, and
//! all of it can be stored and restored.

mod access;
mod control;
mod distinct;
mod explain;
mod instance;
mod load;
mod participant;
mod plan;
mod stored;
mod yielding;

pub use load::{PlanError, plans};
pub use plan::Plan;

pub(crate) use distinct::distinct;
pub(crate) use instance::{Instance, Phase};
pub(crate) use participant::GivenBack;
pub(crate) use plan::{Cast, Kind, Passage, Script, SituationPlan};
pub(crate) use stored::Unrestorable;
