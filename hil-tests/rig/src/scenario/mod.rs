//! What a scenario file holds, once it is read and valid.

mod load;
mod problem;

use std::collections::BTreeMap;
use std::path::PathBuf;

use config::{NetConfig, Rect, RobotConfig, SiteConfig};

pub use load::load;

/// A scenario: robots on a site, and what they are to do there.
#[derive(Clone, Debug)]
pub struct Scenario {
    /// Its name.
    pub name: String,
    /// What it is about, in a sentence.
    pub about: String,
    /// Site file.
    pub site_file: PathBuf,
    /// What the site file says.
    pub site: SiteConfig,
    /// The nets of the site's coordinations.
    pub nets: Vec<NetConfig>,
    /// Longest time until all goals are reached.
    pub patience_s: f64,
    /// When no robot has moved for so long, they never will.
    pub standstill_s: f64,
    /// Each robot is started after a time of up to this, drawn from the seed.
    pub start_delay_s: f64,
    /// Less clearance is a violation.
    pub least_clearance_m: f64,
    /// The robots, by identity.
    pub robots: Vec<Player>,
    /// So many runs of these coordinations must end, by their ids.
    pub coordinations: BTreeMap<String, u32>,
    /// What must be true while something else is.
    pub during: Vec<During>,
}

/// A robot that takes part.
#[derive(Clone, Debug)]
pub struct Player {
    /// Its identity, also on the site.
    pub id: String,
    /// Robot file.
    pub file: PathBuf,
    /// Values changed in it, `KEY=VALUE`; the last gives it its identity.
    pub set: Vec<String>,
    /// What the robot file says, with these values.
    pub config: RobotConfig,
    /// What it is to do.
    pub goal: Goal,
}

/// Where a robot has to go, in this order; on its way it may be anywhere.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Goal {
    /// How often it goes `through`.
    pub rounds: u32,
    /// The places of one round.
    pub through: Vec<Stop>,
    /// Places after the last round.
    pub then: Vec<Stop>,
}

/// A place on a robot's way: its `base_link` comes there.
#[derive(Clone, Debug, PartialEq)]
pub struct Stop {
    /// What it is called.
    pub name: String,
    /// Where it is.
    pub region: Rect,
    /// For so long it stands there.
    pub stands_s: f64,
}

/// Something that must be true while something else is.
#[derive(Clone, Debug, PartialEq)]
pub struct During {
    /// While the `base_link` of this robot
    pub robot: String,
    /// is in this area,
    pub area: Stop,
    /// and a net of this coordination has the discrete control of robots,
    pub coordination: Option<Coordination>,
    /// this other robot
    pub other: String,
    /// is in this area with its whole footprint.
    pub other_area: Stop,
}

/// A coordination of the site.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Coordination {
    /// Its id in the site file.
    pub id: String,
    /// Its net, by which it is known on the network.
    pub net: String,
}

impl Scenario {
    /// The robot with this identity.
    #[must_use]
    pub fn player(&self, id: &str) -> Option<usize> {
        self.robots.iter().position(|player| player.id == id)
    }

    /// The same scenario in which no robot drives more rounds than this.
    #[must_use]
    pub fn with_at_most(mut self, rounds: u32) -> Self {
        for player in &mut self.robots {
            player.goal.rounds = player.goal.rounds.min(rounds);
        }
        self
    }
}

impl Goal {
    /// All places, one after the other.
    pub fn stops(&self) -> impl Iterator<Item = &Stop> {
        (0..self.rounds)
            .flat_map(|_| self.through.iter())
            .chain(&self.then)
    }
}

impl During {
    /// In a sentence.
    #[must_use]
    pub fn rule(&self) -> String {
        let coordination = self
            .coordination
            .as_ref()
            .map_or(String::new(), |own| format!(" in coordination {}", own.id));
        format!(
            "while {} is in {}{coordination}, all of {} is in {}",
            self.robot, self.area.name, self.other, self.other_area.name
        )
    }
}

#[cfg(test)]
mod tests;
