//! The sheet from top to bottom.

use crate::record::{Record, RobotRecord};
use crate::report::draw::canvas::Canvas;

use super::run::DrawnRun;
use super::schedule::Schedule;
use super::{charts, header, map};

/// Largest size of a drawing of an ordinary site.
#[cfg(test)]
pub(super) const LARGEST_BYTES: usize = 500_000;

/// Draws the way of a robot that was alone; none of several, which [`html`](crate::report::html) shows together.
#[must_use]
pub fn drive_svg(record: &Record) -> Option<String> {
    match &record.robots[..] {
        [robot] => Some(draw(record, robot)),
        _ => None,
    }
}

/// Draws the way of a robot.
pub(super) fn draw(record: &Record, robot: &RobotRecord) -> String {
    let run = DrawnRun::new(record, robot);
    let schedule = Schedule::new(&robot.states);
    let mut canvas = Canvas::default();
    let below_header = header::draw(&mut canvas, &run);
    let below_map = map::draw(&mut canvas, &run, &schedule, below_header);
    let below_charts = charts::draw(&mut canvas, &run, below_map);
    let height_px = header::draw_end(&mut canvas, &run, below_charts);
    canvas.finish(height_px, &header::title(&run))
}
