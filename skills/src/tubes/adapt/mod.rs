//! The tubes of a running robot: scans and wanted commands in, safe commands out.
//!
//! * [`outcome`]: verdicts and reasons;
//! * `sight`: whether scans come, and have come for long enough;
//! * `select`: the tube for a wanted command;
//! * [`room`]: how far aside of its path a detour may lead;
//! * `detour`: the way around what stands in the way;
//! * `retreat`: backing out of a dead end;
//! * [`motion_tubes`]: the run-time object.

mod detour;
pub mod motion_tubes;
pub mod outcome;
mod retreat;
pub mod room;
mod select;
mod sight;
