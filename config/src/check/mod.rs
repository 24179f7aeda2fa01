//! Checks of values against each other, after each has been checked alone: references, and the floor plan.
//! What robots can do on it is judged by `skills`, which gives it its meaning.
//!
//! References are always checked. What computes with numbers runs only when the
//! numbers were readable; a placeholder (NaN) compares as false and stays silent.

mod coordination;
mod floor;
mod fsm;
mod map;
mod net;
mod reference;
mod robot;
mod skills;
mod threads;
mod together;

use crate::loaded::RobotConfig;
use crate::loaded::SiteConfig;
use crate::report::Report;

pub(crate) use net::check as net;
pub use together::check_together;

pub(crate) fn robot(robot: &RobotConfig, report: &Report) {
    threads::check(robot, report);
    robot::check(robot, report);
}

pub(crate) fn site(site: &SiteConfig, report: &Report) {
    map::references(site, report);
    skills::references(site, report);
    fsm::references(site, report);
    coordination::references(site, report);
    // Geometry and meaning need every name and number of the sections they look at.
    if !report.touched(&["walls", "lanes", "areas", "perception"]) {
        map::geometry(site, report);
        if !report.touched(&["walls", "lanes", "areas", "robots"]) {
            floor::check(site, report);
        }
    }
    if !report.touched(&["walls", "lanes", "areas", "fsm", "robots"]) {
        map::starts(site, report);
    }
}
