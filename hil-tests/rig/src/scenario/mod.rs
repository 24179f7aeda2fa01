//! What a scenario file holds, once it is read and valid.
//!
//! - [`Scenario`]: robots on a site, what they are to do, and what must not happen;
//! - [`Goal`]: what one robot is to do;
//! - [`Limits`]: figures beyond which something is a violation;
//! - [`Clutter`]: obstacles and walkers that the site file does not know;
//! - [`ScriptedFault`]: what goes wrong, on the simulated clock;
//! - [`Recovery`]: by when a fleet must have come through that;
//! - [`load`](fn@load) reads a file, [`load_shipped`] one that ships, with [`Changes`] from the command line.

mod clutter;
mod fault;
mod goal;
mod limits;
mod load;
mod model;
mod problem;
mod recovery;

pub use clutter::{Boxes, Clutter, People, Vehicle};
pub use fault::{
    Direction, GRAVITY_M_S2, SUPERVISOR, ScriptedFault, ScriptedKind, Stopping, WhichMediator,
};
pub(crate) use fault::{OVERLOADED_BY_S, STARTED_AGAIN_S};
pub use goal::{Goal, Places, Stop};
pub use limits::Limits;
pub use load::{Changes, load, load_shipped};
pub use model::{Coordination, During, LONGEST_DRIVEN_H, Player, Scenario};
pub use recovery::{HELPED_AFTER_S, Recovery};

#[cfg(test)]
mod tests;
