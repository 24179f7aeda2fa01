//! `report.svg`: the way of one robot on one sheet, for people to look at.
//!
//! The upper panel is the map to scale with what was driven on it, the lower one shows speed, clearance and
//! lateral position over time. All of it is drawn from the world's truth; only the marks of schedule changes stand
//! where the robot believed to be. Red is kept for violations and for the limits that they are judged by.
//!
//! The sheet needs nothing else: no script, no font, no other file. However long the run was, it stays under
//! `LARGEST_BYTES` for sites of ordinary size, because curves are thinned to what can be seen.

mod charts;
mod footprints;
mod header;
mod legend;
mod map;
mod marks;
mod run;
mod schedule;
mod sheet;
mod speeds;

#[cfg(test)]
mod tests;

pub use sheet::drive_svg;
