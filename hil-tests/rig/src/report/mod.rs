//! What people look at when a run is over, and what `rig map` draws.
//!
//! - [`html`]: `report.html`, one file that needs nothing else;
//! - [`drive_svg`]: `report.svg` of a robot that is alone, also part of the page: its way, speed, clearance and lane;
//! - [`site_svg`]: a site as its file describes it.

mod draw;
mod drive;
mod page;
mod site;
#[cfg(test)]
mod specimens;

pub use drive::drive_svg;
pub use page::html;
pub use site::site_svg;
