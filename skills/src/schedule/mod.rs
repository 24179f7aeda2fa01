//! Schedules: what runs in each state of the robot's machine.
//!
//! A *skill* joins perception, one controller and monitors. A *schedule* is a skill bound to one state: its area's limits,
//! the lane it drives on, the walls it expects. [`compile`] makes one schedule for each state and finds what the data do
//! not say: the lanes that a turn leads from and to, and the speed to have at a lane's end, follow from the machine's
//! transitions. It checks that each manoeuvre can be driven by the robot in the map: curves that fit between their lanes,
//! walls that are there to dock at, borders that lie ahead. Changing the state changes the schedule, at run time, without
//! allocation.

mod compile;
mod ends;
mod error;
mod graph;
mod manoeuvres;
mod room;
mod setup;

pub use compile::{RobotLimits, compile};
pub use error::ScheduleError;
pub use setup::{ControllerSetup, MonitorSetup, SkillSetup, StateSetup, StopTarget};

use crate::control::{EndOfLane, TurnDirection};
use crate::monitors::{Monitor, MonitorKind};
use crate::perception::FeatureSet;

/// A controller bound to a state.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Controller {
    /// Keeps on [`Schedule::lane`], or beside it.
    Corridor {
        /// Of the path from the lane's centre, positive to the left.
        offset_m: f64,
    },
    /// Up to the end of [`Schedule::lane`].
    EndOfLane(EndOfLane),
    /// From [`Schedule::from_lane`] onto [`Schedule::lane`], which runs the other way.
    UTurn {
        /// To which side.
        direction: TurnDirection,
        /// Of `base_link`'s path.
        radius_m: f64,
    },
    /// From beside [`Schedule::lane`] onto it.
    Shift {
        /// Of the path on the lane from its centre, positive to the left.
        offset_m: f64,
        /// Length of the change.
        within_m: f64,
    },
    /// From [`Schedule::from_lane`] onto [`Schedule::lane`], at a junction.
    Turn {
        /// Of the curve between them.
        radius_m: f64,
    },
    /// Along [`Schedule::lane`] to a place on it.
    StopAt(StopPlace),
    /// Up to the wall that closes [`Schedule::lane`].
    Dock {
        /// From the front of the footprint to the wall.
        distance_m: f64,
    },
    /// Straight forward or backward.
    Creep {
        /// How far; negative: backward.
        distance_m: f64,
    },
    /// Stands still.
    Stop,
}

/// A place on a lane to stop at.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum StopPlace {
    /// The footprint, and the uncertainty of the pose, before a border.
    Border {
        /// Along the lane, of the border.
        along_m: f64,
        /// From the footprint to it.
        margin_m: f64,
    },
    /// `base_link` there.
    Pose {
        /// Along the lane.
        along_m: f64,
        /// Of the path from the lane's centre, positive to the left.
        offset_m: f64,
    },
    /// Where the instruction says.
    Instructed,
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
    /// Index of the lane that a turn leaves.
    pub from_lane: Option<usize>,
    /// Index of the lane whose end is looked for: that of the state, or the one that a U-turn leaves.
    pub end_lane: Option<usize>,
    /// Features that correct the pose.
    pub tracks: FeatureSet,
    /// Features that run at all.
    pub features: FeatureSet,
    /// What moves the robot.
    pub controller: Controller,
    /// What raises events.
    pub monitors: Vec<Monitor>,
    /// Of the area and the skill.
    pub speed_limit_m_s: f64,
    /// Of the area.
    pub deviation_limit_m: f64,
}

impl Schedule {
    /// The least of the area's limit and of those that its monitors watch.
    #[must_use]
    pub fn keep_within_m(&self) -> f64 {
        let limits = self
            .monitors
            .iter()
            .filter_map(|monitor| match monitor.kind {
                MonitorKind::Deviation { limit_m } => limit_m,
                _ => None,
            });
        limits.fold(self.deviation_limit_m, f64::min)
    }
}

#[cfg(test)]
mod tests;
