//! What one robot is to do.

use description::geometry::Rect;

/// What a robot is to do; judged by the world's truth.
#[derive(Clone, Debug, PartialEq)]
pub enum Goal {
    /// To come to places in their order.
    Places(Places),
    /// To drive this many laps, on any site: two U-turns, one after the other, each left for a lane.
    Laps(u32),
    /// To pass through every regular state of its machine, and to come back to the one in which it started.
    EveryState,
}

/// Where a robot has to go, in this order; on its way it may be anywhere.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Places {
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
    /// Where it is, in `map`.
    pub region: Rect,
    /// The robot stands there at least this long.
    pub stands_s: f64,
}

impl Goal {
    /// Rounds or laps that the robot is to drive; a goal without either counts as one round.
    #[must_use]
    pub fn rounds(&self) -> u32 {
        match self {
            Self::Places(places) => places.rounds,
            Self::Laps(laps) => *laps,
            Self::EveryState => 1,
        }
    }

    /// Lowers the number of rounds to this, if there are more.
    pub fn limit_rounds(&mut self, most: u32) {
        match self {
            Self::Places(places) => places.rounds = places.rounds.min(most),
            Self::Laps(laps) => *laps = (*laps).min(most),
            Self::EveryState => {}
        }
    }
}

impl Places {
    /// All places, one after the other.
    pub fn stops(&self) -> impl Iterator<Item = &Stop> {
        (0..self.rounds)
            .flat_map(|_| self.through.iter())
            .chain(&self.then)
    }
}
