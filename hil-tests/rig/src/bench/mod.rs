//! `rig bench`: how fast and how punctual the parts of a robot are on this machine, each beside a rival.
//!
//! Contenders take turns in windows of one run, so that what disturbs the machine disturbs all of them. What is worth comparing is a
//! ratio of one run; a figure alone is of this machine and this hour. The machine's own stalls are watched, and samples in which one
//! lies are counted apart.
//!
//! The modules, from the lowest level to the highest:
//!
//! - [`samples`]: what was measured, and percentiles of it; [`promises`]: what these must keep; [`report`]: `bench.json`; [`table`]: the same
//!   for people;
//! - [`windows`]: contenders that take turns; [`measuring`], [`place`], [`cycle`]: threads that measure, their cores and priorities, and how
//!   they repeat it; [`load`]: other work;
//! - [`wakeup`], [`symbols`], [`events`], [`bus`], [`tubes`], [`work`], [`robot`], [`mediator`]: the parts;
//! - [`options`], [`command`]: the command line, and all parts in a row.

pub mod bus;
pub mod command;
pub mod cycle;
pub mod events;
pub mod load;
pub mod measuring;
pub mod mediator;
pub mod options;
pub mod place;
pub mod promises;
pub mod report;
pub mod robot;
pub mod samples;
pub mod symbols;
pub mod table;
pub mod tubes;
pub mod wakeup;
pub mod windows;
pub mod work;
