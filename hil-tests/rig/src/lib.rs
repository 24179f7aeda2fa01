//! The rig: simulated devices, robots and the mediator as processes, and a judge that believes the world and not the robot.
//!
//! One robot is a fleet of one: a [`scenario`] says which robots drive on a site, what they are to do there and what must
//! not happen; a [`run`] of it has a [`judge`], a [`record`], a [`summary`] and a [`report`], however it is run: through the
//! real programs in real time, or [`stepped`] in one process on a simulated clock.
//!
//! ```
//! use rig::campaign::stepped::summary;
//! use rig::scenario::{Changes, load};
//! use rig::stepped::Plans;
//! use rig::violation::ViolationKind;
//!
//! let file = "../../config/scenarios/lap.toml";
//! let mut scenario = load(file.as_ref(), &Changes::default())?.with_at_most(1);
//! let (plans, seed) = (Plans::of(&scenario)?, 1);
//! let driven = summary(&scenario, &plans, seed, true)?;
//! assert!(driven.passed() && driven.robots[0].laps == 1);
//!
//! // The same run, but the robot must keep 1 m clear of everything, which the corridor does not allow.
//! scenario.limits.clearance_m = 1.0;
//! let judged = summary(&scenario, &plans, seed, true)?;
//! assert!(judged.is_done() && !judged.passed());
//! assert_eq!(judged.violations[0].kind, ViolationKind::Clearance);
//! # Ok::<(), onboard::cli::Failure>(())
//! ```
//!
//! The modules, from the lowest level to the highest:
//!
//! - [`shapes`], [`lanes`], [`testbed`]: a world and the devices of its robots, built from the users' own files;
//!   [`interfaces`]: a fieldbus without wires;
//! - [`process`]: robots and the mediator as child processes: this program, started with a hidden subcommand;
//! - [`network`]: what robots and mediator say, heard as any third party could; [`belief`]: what a robot believes;
//! - [`stand_ins`]: the rig in the place of people and of the mediator;
//! - [`goals`], [`judge`], [`violation`], [`figures`]: how far robots are, what went wrong, what was measured;
//!   [`percentile`]: one rule for medians and percentiles;
//! - [`run`], [`stepped`], [`campaign`]: one run, the two ways to run it, and many runs;
//! - [`commands`], [`map`](mod@map), [`devices`], [`bench`](mod@bench), [`cli`]: what the program does.

pub mod belief;
pub mod bench;
pub mod campaign;
pub mod cli;
pub mod commands;
pub mod devices;
pub mod figures;
pub mod folder;
pub mod goals;
pub mod interfaces;
pub mod judge;
pub mod lanes;
pub mod machine;
pub mod map;
pub mod network;
pub mod output;
pub mod percentile;
pub mod process;
pub mod record;
pub mod report;
pub mod run;
pub mod scenario;
pub mod shapes;
pub mod stalls;
pub mod stand_ins;
pub mod stepped;
pub mod summary;
pub mod testbed;
#[cfg(test)]
mod testing;
pub mod threads;
pub mod violation;
