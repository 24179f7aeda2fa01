//! From a site file to what the manager needs.

use std::time::Duration;

use config::{Area, SiteConfig};
use contract::timing::SILENT_AFTER_NS;

use crate::setup::{AreaSetup, RobotSetup, Setup, SetupError};

/// No footprint reaches farther than this from its start pose: the areas within this distance count as occupied until the robot
/// is heard.
const REACH_M: f64 = 1.0;

impl Setup {
    /// The areas and robots of a site file.
    ///
    /// # Errors
    /// [`SetupError`] when ids or capacities do not suit the mediator.
    pub fn of(site: &SiteConfig) -> Result<Self, SetupError> {
        let areas = site.areas.iter().map(|area| AreaSetup {
            id: area.id.clone(),
            capacity: area.capacity,
        });
        let robots = site.robots.iter().map(|(id, robot)| RobotSetup {
            id: id.clone(),
            role: robot.role.clone(),
            priority: { site.roles.get(&robot.role) }.map_or(0, |role| role.priority),
            starts_in: site
                .areas
                .iter()
                .filter(|area| distance_m(area, [robot.start.x_m, robot.start.y_m]) < REACH_M)
                .map(|area| area.id.clone())
                .collect(),
        });
        let setup = Self {
            site: site.name.clone(),
            areas: areas.collect(),
            robots: robots.collect(),
            silent_after: Duration::from_nanos(SILENT_AFTER_NS),
        };
        setup.check()?;
        Ok(setup)
    }
}

/// From a point to the nearest point of an area.
fn distance_m(area: &Area, point_m: [f64; 2]) -> f64 {
    let beyond = |axis: usize| {
        let below = area.region.min_m[axis] - point_m[axis];
        let above = point_m[axis] - area.region.max_m[axis];
        below.max(above).max(0.0)
    };
    beyond(0).hypot(beyond(1))
}
