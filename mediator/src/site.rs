//! From a site file to what the manager needs.

use std::time::Duration;

use config::SiteConfig;
use contract::floor::Floor;
use contract::timing::SILENT_AFTER_NS;

use crate::setup::{AreaSetup, LONGEST_REACH_M, RobotSetup, Setup, SetupError};

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
            ages_after: { site.roles.get(&robot.role) }.map_or(0, |role| role.ages_after),
            starts_in: site
                .areas
                .iter()
                .filter(|area| area.region.distance_m(robot.start.position()) < LONGEST_REACH_M)
                .map(|area| area.id.clone())
                .collect(),
        });
        let setup = Self {
            site: site.name.clone(),
            areas: areas.collect(),
            floor: Floor::of(&site.areas),
            robots: robots.collect(),
            silent_after: Duration::from_nanos(SILENT_AFTER_NS),
        };
        setup.check()?;
        Ok(setup)
    }
}
