//! `report.svg`: one robot's run on one page, for people to look at.
//!
//! The upper panel is the map to scale with what was driven on it, the lower one shows speed, clearance and
//! lateral position over time. All of it is drawn from the world's truth; only the marks of schedule changes stand
//! where the robot believed to be. Red is kept for violations and for the limits that they are judged by.
//!
//! The page needs nothing else: no script, no font, no other file. However long the run was, it stays under
//! [`LARGEST_BYTES`] for sites of ordinary size, because curves are thinned to what can be seen.

mod canvas;
mod charts;
pub mod fleet;
mod floor;
mod footprints;
mod frame;
mod header;
mod labels;
mod legend;
mod map;
mod marks;
mod page;
mod run;
mod scale;
mod schedule;
mod site;
mod thin;

#[cfg(test)]
mod tests;

use config::{RobotConfig, SiteConfig};
use sim::world::{Shape, Truth};

use crate::one_robot::judge::{LARGEST_LATERAL_ERROR_M, LEAST_CLEARANCE_M};
use crate::one_robot::listener::Change;
use crate::one_robot::summary::Summary;

use canvas::Canvas;
pub use page::html;
pub use site::site_svg;

use run::Run;
use schedule::Schedule;

/// What a report of an ordinary site stays under.
pub const LARGEST_BYTES: usize = 500_000;

/// Width of the page in pixels, and what is left free at its sides.
const WIDTH_PX: f64 = 1600.0;
const MARGIN_PX: f64 = 40.0;
/// Map and charts begin and end here.
const PLOT_LEFT_PX: f64 = 96.0;
const PLOT_RIGHT_PX: f64 = WIDTH_PX - MARGIN_PX;

/// What is drawn as wrong.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Limits {
    /// Less clearance is.
    pub clearance_m: Option<f64>,
    /// A larger lateral error on a lane is.
    pub lateral_m: Option<f64>,
}

impl Limits {
    /// Those of a robot that keeps to its lane.
    pub const LANE: Self = Self {
        clearance_m: Some(LEAST_CLEARANCE_M),
        lateral_m: Some(LARGEST_LATERAL_ERROR_M),
    };
    /// Only contact is.
    pub const CONTACT: Self = Self {
        clearance_m: None,
        lateral_m: None,
    };
}

/// Draws the run of `robot`: `path` is its true states in order of time, `changes` may hold those of others, too;
/// `obstacles` are what the site does not know, as they stood at the end.
#[must_use]
pub fn svg(
    site: &SiteConfig,
    robot: &RobotConfig,
    path: &[Truth],
    changes: &[Change],
    summary: &Summary,
    limits: &Limits,
    obstacles: &[Shape],
) -> String {
    let run = Run::new(site, robot, path, summary, *limits, obstacles);
    let schedule = Schedule::new(&robot.identity.id, changes);
    let mut canvas = Canvas::default();
    let below_header = header::draw(&mut canvas, &run);
    let below_map = map::draw(&mut canvas, &run, &schedule, below_header);
    let below_charts = charts::draw(&mut canvas, &run, below_map);
    let height_px = header::draw_end(&mut canvas, &run, below_charts);
    canvas.finish(height_px, &header::title(&run))
}
