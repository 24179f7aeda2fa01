//! Laps: on any site, two U-turns that were entered one after the other and left for a lane.

use config::SiteConfig;
use description::geometry::Rect;
use description::site::Manoeuvre;
use sim::world::Truth;

use crate::lanes::forward_lane;

/// One robot's laps.
#[derive(Clone, Debug)]
pub(super) struct Laps {
    areas: Vec<Area>,
    /// Index of the area that was entered last.
    area: Option<usize>,
    turns: u32,
}

#[derive(Clone, Debug)]
struct Area {
    region: Rect,
    is_turn: bool,
    is_lane: bool,
}

impl Laps {
    /// None driven yet.
    pub(super) fn new(site: &SiteConfig) -> Self {
        let areas = { site.areas.iter() }
            .map(|area| Area {
                region: area.region,
                is_turn: area.control.manoeuvre == Manoeuvre::UTurn,
                is_lane: forward_lane(site, area).is_some(),
            })
            .collect();
        Self {
            areas,
            area: None,
            turns: 0,
        }
    }

    /// Takes in where the robot is.
    pub(super) fn observe(&mut self, truth: &Truth) {
        let at_m = [truth.pose.x_m, truth.pose.y_m];
        let here = { self.areas.iter() }.position(|area| area.region.contains(at_m.into()));
        if here.is_none() || here == self.area {
            return;
        }
        let is = |index: Option<usize>, of: fn(&Area) -> bool| {
            index.is_some_and(|index| of(&self.areas[index]))
        };
        if is(self.area, |area| area.is_turn) && is(here, |area| area.is_lane) {
            self.turns += 1;
        }
        self.area = here;
    }

    /// Whole laps.
    pub(super) fn laps(&self) -> u32 {
        self.turns / 2
    }
}
