//! Laps: on any site, two U-turns that were entered one after the other and left for a lane.

use config::SiteConfig;
use description::geometry::Rect;
use description::site::Manoeuvre;
use sim::world::Truth;

use crate::lanes::forward_lane;

/// One robot's laps.
#[derive(Clone, Debug)]
pub struct Laps {
    areas: Vec<Area>,
    /// Index of the area that was entered last.
    area: Option<usize>,
    turns: u32,
    wanted: u32,
    done_ns: Option<u64>,
}

#[derive(Clone, Debug)]
struct Area {
    region: Rect,
    is_turn: bool,
    is_lane: bool,
}

impl Laps {
    /// None driven yet of those wanted.
    #[must_use]
    pub fn new(site: &SiteConfig, wanted: u32) -> Self {
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
            wanted,
            done_ns: None,
        }
    }

    /// Takes in where the robot is.
    pub fn observe(&mut self, truth: &Truth) {
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
        if self.laps() >= self.wanted {
            self.done_ns.get_or_insert(truth.time_ns);
        }
    }

    /// Whole laps.
    #[must_use]
    pub fn laps(&self) -> u32 {
        self.turns / 2
    }

    /// Laps that the robot is to drive.
    #[must_use]
    pub fn wanted(&self) -> u32 {
        self.wanted
    }

    /// When the last one was done.
    #[must_use]
    pub fn done_ns(&self) -> Option<u64> {
        self.done_ns
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use sim::world::Pose;

    #[test]
    fn a_lap_is_two_turns_driven_through() {
        let file = concat!(
            env!("CARGO_MANIFEST_DIR"),
            "/../../config/sites/corridor.toml"
        );
        let site = config::load_site(file, &[]).expect("the site that ships is good");
        let mut laps = Laps::new(&site, 1);
        let truth = |x_m: f64, y_m: f64| Truth {
            time_ns: 1_000_000_000,
            pose: Pose::new(x_m, y_m, 0.0),
            ..Truth::default()
        };
        let circuit = [
            (2.0, -0.5),
            (7.0, -0.5),
            (9.0, 0.0),
            (7.0, 0.5),
            (3.0, 0.5),
            (1.0, 0.0),
        ];
        for (x_m, y_m) in circuit {
            laps.observe(&truth(x_m, y_m));
        }
        assert_eq!(laps.laps(), 0, "the second turn has not been left");
        laps.observe(&truth(2.0, -0.5));
        assert_eq!((laps.laps(), laps.done_ns()), (1, Some(1_000_000_000)));
    }
}
