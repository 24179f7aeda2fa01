//! Whether the site's robots can come to wait for ever, by the order of their areas, its standing nets and their machines together.
//!
//! All placements of the robots that can be reached are explored, step by step as the mediator would let them: a robot is in the
//! areas of its machine's state, asks for those of the states that can follow, and keeps what it has until it is there ([`Route`]).
//! Which state follows, its machine decides by itself, by events of its skills and from outside, whatever is free. Areas that a net
//! decides about are granted where it lets the robot in ([`GateNet`]); its transitions fire in any order, but for rounds without
//! end, in which each net chooses as its executor does.
//!
//! Coordinations that take the discrete control of robots begin where robots are as a situation wants them, keep areas for their
//! orders, and get out of the way or let go at any time that something may have taken too long ([`ControlNet`]). Orders come late: what
//! a robot does before it hears one is looked at as well. Events that coordinations post come from them alone.
//!
//! Taken for granted is that whatever makes a robot stop sends it on at last, that people see to robots that fail, and that a robot asks
//! for no more than its next areas. Left out are speeds, regions of situations, and coordinations that let some robots into areas and
//! take the discrete control of others: their nets are judged alone, and whoever waits for them is not seen to wait.
//!
//! Found is, with the shortest steps that lead there, every placement from which some robot can never go on ([`Verdict::May`]), and
//! every round in which one waits for ever while others go on, though all are fair but those of a larger priority
//! ([`Verdict::Starves`]); and, whatever the verdict is, for each robot who waits for it when it dies somewhere ([`Death`]). Of a floor that is
//! too large, those that wait by the order of their areas are found, as far as it was looked at ([`Verdict::Unknown`]).
//!
//! [`Route`]: route::Route
//! [`GateNet`]: gate_net::GateNet
//! [`ControlNet`]: control_net::ControlNet

mod control_net;
mod deaths;
mod explore;
mod floor;
mod gate_net;
mod graph;
mod judge;
mod route;
mod starvation;
mod state;
mod steps;
mod talk;
mod tokens;
mod verdict;
mod waiting;
mod ways;
mod words;

use std::sync::Arc;

use config::SiteConfig;

use crate::nets::Plan;
pub(crate) use verdict::{Death, Findings, Still, Verdict, Waits};
pub(crate) use words::is_looked_at;

use floor::Floor;

#[cfg(test)]
mod beside_mediator;
#[cfg(test)]
mod control_tests;
#[cfg(test)]
mod small_floors;
#[cfg(test)]
mod tests;

/// Explores a site with its coordinations.
pub(crate) fn look(site: &SiteConfig, plans: &[Arc<Plan>]) -> Findings {
    judge_floor(&Floor::new(site, plans))
}

fn judge_floor(floor: &Floor) -> Findings {
    judge::judge(floor, &floor.explore())
}
