//! Schedules: what runs in each state of the robot's machine.
//!
//! A *skill* joins perception, one controller and monitors. A *schedule* is a skill bound to one state: its area's limits,
//! the lane it drives on, the walls it expects. [`compile`] makes one schedule for each state and finds what the data do
//! not say: the lanes a U-turn leads from and to, and the speed to have at a lane's end, follow from the machine's
//! transitions. Changing the state changes the schedule, at run time, without allocation.

mod compile;
mod setup;

pub use compile::compile;
pub use setup::{ControllerSetup, MonitorSetup, SkillSetup, StateSetup, StopTarget};

use crate::control::{EndOfLane, TurnDirection};
use crate::monitors::Monitor;
use crate::perception::FeatureSet;

/// What does not fit together.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum ScheduleError {
    /// A state of the machine has no meaning, or two.
    #[error("state `{state}` of the machine is described {found} times, expected once")]
    State {
        /// The state.
        state: String,
        /// How often it is described.
        found: usize,
    },
    /// A name that nothing has.
    #[error("{kind} `{id}` names the {wanted} `{name}`, which does not exist")]
    Unknown {
        /// What names it.
        kind: &'static str,
        /// Its name.
        id: String,
        /// What is named.
        wanted: &'static str,
        /// The name that nothing has.
        name: String,
    },
    /// The controller needs a lane.
    #[error("state `{state}` needs {wanted}, and neither its area nor its neighbours give one")]
    NoLane {
        /// The state.
        state: String,
        /// Which lane.
        wanted: &'static str,
    },
    /// A parameter is not a positive number.
    #[error("{what} of skill `{skill}` must be {expected}, found {found}")]
    Parameter {
        /// The skill.
        skill: String,
        /// Which parameter.
        what: &'static str,
        /// What is expected.
        expected: &'static str,
        /// Found.
        found: f64,
    },
    /// A manoeuvre that cannot be driven.
    #[error("state `{state}` cannot be driven: {reason}")]
    Manoeuvre {
        /// The state.
        state: String,
        /// Why.
        reason: String,
    },
    /// A U-turn leads away from its outgoing lane.
    #[error(
        "the U-turn in state `{state}` turns away from lane `{outgoing}`, which lies on the other side of `{incoming}`"
    )]
    TurnSide {
        /// The state.
        state: String,
        /// Where it comes from.
        incoming: String,
        /// Where it should lead.
        outgoing: String,
    },
}

/// A controller bound to a state.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Controller {
    /// Keeps on [`Schedule::lane`].
    Corridor,
    /// Up to the end of [`Schedule::lane`].
    EndOfLane(EndOfLane),
    /// From [`Schedule::end_lane`] onto [`Schedule::lane`].
    UTurn {
        /// To which side.
        direction: TurnDirection,
        /// Of `base_link`'s path.
        radius_m: f64,
    },
    /// Stands still.
    Stop,
}

/// What runs in one state.
#[derive(Clone, Debug, PartialEq)]
pub struct Schedule {
    /// Index of the skill.
    pub skill: usize,
    /// Index of the area.
    pub area: Option<usize>,
    /// Index of the lane that the robot drives on, or onto.
    pub lane: Option<usize>,
    /// Index of the lane whose end is looked for: the same, or the one that a U-turn leaves.
    pub end_lane: Option<usize>,
    /// Features that correct the pose.
    pub tracks: FeatureSet,
    /// Features that run at all.
    pub features: FeatureSet,
    /// What moves the robot.
    pub controller: Controller,
    /// What raises events.
    pub monitors: Vec<Monitor>,
    /// Of the area.
    pub speed_limit_m_s: f64,
    /// Of the area.
    pub deviation_limit_m: f64,
}

#[cfg(test)]
mod tests;
