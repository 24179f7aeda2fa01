//! The tubes of a running robot: scans and wanted commands in, safe commands out.
//!
//! * [`outcome`]: verdicts and reasons;
//! * `sight`: whether scans arrive, and have arrived for long enough;
//! * `select`: the tube for a wanted command;
//! * [`room`]: how far beside its path a detour may lead;
//! * `detour`: the way around what stands in the way;
//! * [`stop_rules`]: how it must stop, whatever the policy;
//! * `retreat`: backing out of a dead end;
//! * [`motion_tubes`]: the run-time object; `observe`, `speed` and `command`: what it does.
//!
//! [`MotionTubes::observe`] judges all tubes on a scan. [`MotionTubes::adapt`] may be asked as often as one likes; between
//! two scans the speed it allows only falls. A command it returns can always be stopped inside a free tube:
//! v·(scan age + reaction) + v² / (2·a) stays within the tube's length; and before something that moves arrives, see
//! `moving`. Neither allocates, locks or fails.
//!
//! It stops for one of the reasons in [`Reason`], says which and since when, and drives on by itself when the
//! reason has been gone for the time that the policy names.

mod command;
mod detour;
pub mod motion_tubes;
mod observe;
pub mod outcome;
mod retreat;
pub mod room;
mod select;
mod sight;
mod speed;
pub mod stop_rules;

#[cfg(doc)]
use {motion_tubes::MotionTubes, outcome::Reason};
