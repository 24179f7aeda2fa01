//! Which lane a robot keeps to.

use config::SiteConfig;
use description::site::{Area, FsmState, Lane, Manoeuvre};

/// The lane of an area that is driven forward on one.
#[must_use]
pub fn forward_lane<'a>(site: &'a SiteConfig, area: &Area) -> Option<&'a Lane> {
    let lane = site.lane(area.lane.as_ref()?)?;
    (area.control.manoeuvre == Manoeuvre::Forward).then_some(lane)
}

/// The lane of a state of the machine: its own, or that of its area.
#[must_use]
pub fn lane_of<'a>(site: &'a SiteConfig, state: &FsmState) -> Option<&'a Lane> {
    let area = site.area(&state.area);
    let lane = { state.lane.as_ref() }.or(area.and_then(|area| area.lane.as_ref()))?;
    site.lane(lane)
}
