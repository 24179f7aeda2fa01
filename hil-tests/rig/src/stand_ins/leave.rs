//! Leave for areas, withheld at random as by a mediator that has promised them to others.
//!
//! Leave is never taken back from a robot that is in an area or too near to stop before it: whether the next visit gets
//! leave is decided when the robot has left. A robot that stands before a withheld area gets leave after up to
//! `LONGEST_WAIT_S`.

use config::SiteConfig;
use sim::world::{Footprint, Pose, Random, STANDING_M_S};

use crate::shapes::region;

/// Share of visits for which leave is withheld at first.
const WITHHELD_SHARE: f64 = 0.3;
/// The next visit is decided when the robot has left the area this far behind.
const LEFT_M: f64 = 0.3;
/// Areas nearer than this to the start are granted: no robot could stop before them.
const START_M: f64 = 0.6;
/// A robot that stands at most this far from an area waits for it.
const WAITING_M: f64 = 1.5;
const LONGEST_WAIT_S: f64 = 5.0;
const LEAVE_STREAM: u64 = 0x4C45_4156;

/// Leave for one area.
#[derive(Clone, Debug)]
struct Leave {
    granted: bool,
    // The robot has been in it since it was granted.
    used: bool,
    wait_s: f64,
    waiting_since_ns: Option<u64>,
}

/// Gives and withholds leave for all areas of a site.
#[derive(Clone, Debug)]
pub struct LeaveKeeper {
    leaves: Vec<Leave>,
    random: Random,
    // Share of visits for which leave is withheld at first.
    share: f64,
    withheld: u64,
}

impl LeaveKeeper {
    /// Every area is granted, always.
    #[must_use]
    pub fn generous(site: &SiteConfig) -> Self {
        Self {
            leaves: vec![Leave::granted(); site.areas.len()],
            random: Random::new(0, LEAVE_STREAM),
            share: 0.0,
            withheld: 0,
        }
    }

    /// Withholds at random, but for the areas around the start.
    #[must_use]
    pub fn random(site: &SiteConfig, footprint: &Footprint, start: &Pose, seed: u64) -> Self {
        let mut keeper = Self::generous(site);
        keeper.random = Random::new(seed, LEAVE_STREAM);
        keeper.share = WITHHELD_SHARE;
        let floor = footprint.at(start);
        for index in 0..keeper.leaves.len() {
            let distance_m = floor.distance_to_rectangle_m(&region(&site.areas[index].region));
            keeper.leaves[index] = keeper.draw();
            if distance_m < START_M {
                keeper.leaves[index] = Leave::granted();
            }
        }
        keeper
    }

    /// Whether each area is granted, in the site's order.
    pub fn granted(&self) -> impl Iterator<Item = bool> + '_ {
        self.leaves.iter().map(|leave| leave.granted)
    }

    /// How often leave was withheld and then given to a waiting robot.
    #[must_use]
    pub fn withheld(&self) -> u64 {
        self.withheld
    }

    /// Looks at the robot; true when leave has changed.
    pub fn look(
        &mut self,
        site: &SiteConfig,
        footprint: &Footprint,
        pose: &Pose,
        speed_m_s: f64,
        now_ns: u64,
    ) -> bool {
        let floor = footprint.at(pose);
        let mut changed = false;
        for (index, area) in site.areas.iter().enumerate() {
            let distance_m = floor.distance_to_rectangle_m(&region(&area.region));
            let leave = &mut self.leaves[index];
            if distance_m <= 0.0 {
                leave.used = true;
            } else if leave.used && distance_m > LEFT_M {
                let before = leave.granted;
                self.leaves[index] = self.draw();
                changed |= before != self.leaves[index].granted;
            } else if !leave.granted {
                let waits = speed_m_s.abs() < STANDING_M_S && distance_m < WAITING_M;
                let since_ns = *leave.waiting_since_ns.get_or_insert(now_ns);
                if !waits {
                    leave.waiting_since_ns = None;
                } else if (now_ns - since_ns) as f64 > leave.wait_s * 1e9 {
                    *leave = Leave::granted();
                    self.withheld += 1;
                    changed = true;
                }
            }
        }
        changed
    }

    fn draw(&mut self) -> Leave {
        let granted = self.random.unit() >= self.share;
        Leave {
            granted,
            wait_s: self.random.unit() * LONGEST_WAIT_S,
            ..Leave::granted()
        }
    }
}

impl Leave {
    fn granted() -> Self {
        Self {
            granted: true,
            used: false,
            wait_s: 0.0,
            waiting_since_ns: None,
        }
    }
}
