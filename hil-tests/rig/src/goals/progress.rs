//! How far one robot is with its goal.

use config::SiteConfig;
use sim::world::Truth;

use super::laps::Laps;
use super::places::Way;
use super::states::States;
use crate::figures::Figures;
use crate::scenario::{Goal, Player};

/// How far a robot is with its goal.
#[derive(Clone, Debug)]
pub struct Progress {
    reached: Reached,
    wanted: u32,
    done_ns: Option<u64>,
}

/// What it has reached of its goal.
#[derive(Clone, Debug)]
enum Reached {
    Places(Way),
    Laps(Laps),
    States(States),
}

impl Progress {
    /// At the beginning.
    #[must_use]
    pub fn new(site: &SiteConfig, player: &Player) -> Self {
        let reached = match &player.goal {
            Goal::Places(places) => Reached::Places(Way::new(places)),
            Goal::Laps(_) => Reached::Laps(Laps::new(site)),
            Goal::EveryState => {
                Reached::States(States::new(site, &player.fsm, player.start_state()))
            }
        };
        Self {
            reached,
            wanted: player.goal.rounds(),
            done_ns: None,
        }
    }

    /// Takes in where the robot is, and what is known of its run.
    pub fn observe(&mut self, truth: &Truth, figures: &Figures) {
        let is_done = match &mut self.reached {
            Reached::Places(way) => {
                way.observe(truth);
                way.next().is_none()
            }
            Reached::Laps(laps) => {
                laps.observe(truth);
                laps.laps() >= self.wanted
            }
            Reached::States(states) => states.is_done(&figures.states, &figures.areas),
        };
        if is_done {
            self.done_ns.get_or_insert(truth.time_ns);
        }
    }

    /// Whole rounds or laps.
    #[must_use]
    pub fn rounds(&self) -> u32 {
        match &self.reached {
            Reached::Places(way) => way.rounds(),
            Reached::Laps(laps) => laps.laps(),
            Reached::States(_) => u32::from(self.done_ns.is_some()),
        }
    }

    /// Rounds or laps that the robot is to drive.
    #[must_use]
    pub fn wanted(&self) -> u32 {
        self.wanted
    }

    /// When it was done.
    #[must_use]
    pub fn done_ns(&self) -> Option<u64> {
        self.done_ns
    }

    /// What this robot has not done yet, in words; none: nothing is left to do.
    #[must_use]
    pub fn missing(&self, robot: &str, figures: &Figures) -> Option<String> {
        let (rounds, wanted) = (self.rounds(), self.wanted);
        let of = |what: &str| format!("{robot} has driven {rounds} of {wanted} {what}");
        match &self.reached {
            Reached::Places(way) => {
                { way.next() }.map(|next| format!("{} and has to go to {next}", of("rounds")))
            }
            _ if self.done_ns.is_some() => None,
            Reached::Laps(_) => Some(of("laps")),
            Reached::States(states) => Some(states.missing(&figures.states)),
        }
    }
}
