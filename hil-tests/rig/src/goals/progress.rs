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
pub enum Progress {
    /// Of places that it has to come to.
    Places(Way),
    /// Of laps.
    Laps(Laps),
    /// Of the states of its machine, and when it was done.
    States(States, Option<u64>),
}

impl Progress {
    /// At the beginning.
    #[must_use]
    pub fn new(site: &SiteConfig, player: &Player) -> Self {
        match &player.goal {
            Goal::Places(places) => Self::Places(Way::new(places)),
            Goal::Laps(laps) => Self::Laps(Laps::new(site, *laps)),
            Goal::EveryState => {
                Self::States(States::new(site, &player.fsm, player.start_state()), None)
            }
        }
    }

    /// Takes in where the robot is, and what is known of its run.
    pub fn observe(&mut self, truth: &Truth, figures: &Figures) {
        match self {
            Self::Places(way) => way.observe(truth),
            Self::Laps(laps) => laps.observe(truth),
            Self::States(states, done_ns) => {
                if done_ns.is_none() && states.is_done(&figures.states, &figures.areas) {
                    *done_ns = Some(truth.time_ns);
                }
            }
        }
    }

    /// Whole rounds or laps.
    #[must_use]
    pub fn rounds(&self) -> u32 {
        match self {
            Self::Places(way) => way.rounds(),
            Self::Laps(laps) => laps.laps(),
            Self::States(_, done_ns) => u32::from(done_ns.is_some()),
        }
    }

    /// Rounds or laps that the robot is to drive.
    #[must_use]
    pub fn wanted(&self) -> u32 {
        match self {
            Self::Places(way) => way.wanted(),
            Self::Laps(laps) => laps.wanted(),
            Self::States(..) => 1,
        }
    }

    /// When it was done.
    #[must_use]
    pub fn done_ns(&self) -> Option<u64> {
        match self {
            Self::Places(way) => way.done_ns(),
            Self::Laps(laps) => laps.done_ns(),
            Self::States(_, done_ns) => *done_ns,
        }
    }

    /// What this robot has not done yet, in words; none: nothing is left to do.
    #[must_use]
    pub fn missing(&self, robot: &str, figures: &Figures) -> Option<String> {
        match self {
            Self::Places(way) => way.next().map(|next| {
                format!(
                    "{robot} has driven {} of {} rounds and has to go to {next}",
                    way.rounds(),
                    way.wanted()
                )
            }),
            Self::Laps(laps) => laps.done_ns().is_none().then(|| {
                format!(
                    "{robot} has driven {} of {} laps",
                    laps.laps(),
                    laps.wanted()
                )
            }),
            Self::States(states, done_ns) => {
                done_ns.is_none().then(|| states.missing(&figures.states))
            }
        }
    }
}
