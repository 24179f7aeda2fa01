//! What the robot's side of the mediator knows of robot and site before anybody speaks.

use contract::floor::Floor;
use contract::wire::Factsheet;
use coordination::event::EventId;
use coordination::fsm::StateId;
use description::areas::AreaIndex;
use description::geometry::{Footprint, Pose2, Rect};
use skills::borders::BorderGains;

/// Leave to be in areas expires when communication has not repeated it to navigation for this long.
pub const LEAVE_AGE_NS: u64 = 1_000_000_000;

/// One robot on one site.
#[derive(Clone, Debug, PartialEq)]
pub struct Setup {
    /// Semantic id of the robot.
    pub robot_id: String,
    /// Name of the site.
    pub site: String,
    /// Tells this start of the process from others.
    pub boot_epoch: u64,
    /// What the process before has left.
    pub began: Began,
    /// The robot's start by its files, in `map`.
    pub start: Pose2,
    /// Areas, in the order of the map.
    pub areas: Vec<AreaPlace>,
    /// The same as the mediator must know them.
    pub floor: Floor,
    /// States of the robot's machine, in its order.
    pub states: Vec<StatePlan>,
    /// The robot's outline.
    pub footprint: Footprint,
    /// By how much it keeps away from borders that it must not cross.
    pub borders: BorderGains,
    /// Deceleration before a border.
    pub deceleration_m_s2: f64,
    /// Fastest speed of the robot.
    pub max_speed_m_s: f64,
    /// An area is asked for this far ahead, beyond the distance that the robot needs to stop.
    pub request_ahead_m: f64,
    /// A mediator that was not heard for longer is silent.
    pub silent_after_ns: u64,
    /// What kind of robot it is.
    pub factsheet: Factsheet,
}

/// Where a process begins.
#[derive(Clone, Debug, PartialEq)]
pub enum Began {
    /// Navigation goes on from what the process before has left. That is newer than what the mediator knows.
    GoesOn,
    /// At the robot's start; or where the process before has ended as it was asked to, if the mediator knew it there, too.
    Afresh {
        /// There.
        ended: Option<Stood>,
    },
    /// Nobody knows where: an operator will say.
    Lost,
}

impl Setup {
    /// All areas.
    pub(super) fn area_indices(&self) -> impl Iterator<Item = AreaIndex> + Clone + use<> {
        AreaIndex::first(self.areas.len())
    }
}

/// Where a robot stood when its process ended as it was asked to.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Stood {
    /// In `map`.
    pub pose: Pose2,
    /// Standard deviation of its position, along the worse axis.
    pub std_m: f64,
    /// Standard deviation of its heading.
    pub std_rad: f64,
    /// State of its machine.
    pub state: String,
}

/// Where a robot starts.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Start {
    /// In `map`.
    pub pose: Pose2,
    /// Standard deviation of its position.
    pub std_m: f64,
    /// Standard deviation of its heading.
    pub std_rad: f64,
    /// State of the machine.
    pub state: StateId,
}

/// An area.
#[derive(Clone, Debug, PartialEq)]
pub struct AreaPlace {
    /// Semantic id.
    pub id: String,
    /// Where it is.
    pub region: Rect,
}

/// What a state of the robot's machine means for areas. States are numbers of [`Setup::states`].
#[derive(Clone, Debug, Default, PartialEq)]
pub struct StatePlan {
    /// Its name.
    pub name: String,
    /// Areas whose floor the robot takes in it.
    pub areas: Vec<AreaIndex>,
    /// States that may follow by themselves: on events of monitors, not on those from outside.
    pub next: Vec<usize>,
    /// Shortest distance that the robot drives from entering the state to leaving it.
    pub least_way_m: f64,
    /// Events on which the state has a transition, with their numbers in the machine.
    pub accepts: Vec<(String, EventId)>,
}

impl StatePlan {
    /// The event of that name, if the state has a transition on it.
    #[must_use]
    pub fn accepts(&self, name: &str) -> Option<EventId> {
        let found = self.accepts.iter().find(|(event, _)| event == name);
        found.map(|(_, number)| *number)
    }
}
