//! Whether the site's robots can come to wait for ever, by the order of their areas, its standing nets and their machines together.
//!
//! All placements of the robots that can be reached are explored, step by step as the mediator would let them: a robot is in the
//! areas of its machine's state, asks for those of the states that follow, and keeps what it has until it is there ([`Route`]).
//! Areas that a net decides about are granted where it lets the robot in ([`GateNet`]); its transitions fire in any order. Left out
//! are speeds and priorities, events from outside, states that only an operator leads out of, and coordinations that take the
//! discrete control of robots: those are judged alone, by the net's own analysis.
//!
//! Found is, with the shortest steps that lead there, every placement from which some robot can never go on ([`Verdict::May`]), and
//! every round in which one waits for ever while others go on, though all are fair ([`Verdict::Starves`]); and, for each robot, whether the nets can still come to a declared end without it when it dies somewhere ([`Death`]).

mod explore;
mod gate_net;
mod graph;
mod judge;
mod route;
mod starvation;
mod state;
mod verdict;

use std::sync::Arc;

use config::SiteConfig;

use crate::nets::Plan;
pub(crate) use verdict::{Verdict, Waits};

use explore::Floor;

#[cfg(test)]
mod tests;

/// Explores a site with its coordinations.
pub(crate) fn look(site: &SiteConfig, plans: &[Arc<Plan>]) -> Verdict {
    let floor = Floor::new(site, plans);
    match floor.explore() {
        Ok(graph) => judge::judge(&floor, &graph),
        Err(looked) => Verdict::Unknown { looked },
    }
}
