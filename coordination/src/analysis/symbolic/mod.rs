//! All states at once, as sets in decision diagrams: for nets that have too many to look at each.
//!
//! A state is a set of variables: one for each marked place, one for the position of each protocol,
//! one for each event that waits ([`rule`](super::closed::rule)). Steps are rules over these variables, and lead from
//! sets to sets ([`space`]). The states are collected in any order first. Only if one of them is
//! faulty they are collected again by their distance, and the nearest faulty one is named, with a
//! shortest way there ([`layers`]).

mod deep;
mod diagram;
mod found;
mod judge;
mod layers;
mod list;
mod order;
mod space;
mod sweep;

pub(super) use found::Symbolic;
pub(super) use list::list;
