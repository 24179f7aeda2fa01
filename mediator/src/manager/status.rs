//! How everything stands, for people.

use serde::{Deserialize, Serialize};

use super::areas::Reservations;
use super::coordinations::CoordinationStatus;
use super::sessions::Factsheet;
use super::view::View;
use crate::journal::ClosedRecord;

/// An area, for people.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct AreaStatus {
    /// Its id.
    pub id: String,
    /// How many robots it holds.
    pub capacity: u32,
    /// Of the last grant.
    pub fence: u64,
    /// Robots that hold it, with the fence of their grant.
    pub holders: Vec<(String, u64)>,
    /// Robots that are in it without holding it, or were when they fell silent.
    pub standing: Vec<String>,
    /// Robots of which a process is in it that does not speak for them, or was when it fell silent.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub seconds: Vec<String>,
    /// Robots for which a coordination keeps it.
    pub kept_for: Vec<String>,
    /// Robots that wait for it, in order.
    pub waiting: Vec<String>,
    /// A silent robot occupies it, or a silent second process of one.
    pub blocked: bool,
    /// Nobody is let in.
    pub closed: bool,
    /// By whom, if an operator has closed it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub closed_by: Option<ClosedRecord>,
}

/// A robot, for people.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct RobotStatus {
    /// Its id.
    pub id: String,
    /// By the site file.
    pub role: String,
    /// Counts its boots; 0: never heard of.
    pub session: u64,
    /// It is heard.
    pub heard: bool,
    /// It reports, whomever it follows.
    #[serde(default)]
    pub reports: bool,
    /// It knows where it is.
    pub located: bool,
    /// Milliseconds since it was heard.
    pub age_ms: u64,
    /// Areas it holds.
    pub holds: Vec<String>,
    /// Areas it waits for, each with the reason.
    pub waits: Vec<(String, String)>,
    /// Why a process that speaks for it was refused.
    pub refusal: String,
    /// A second process reports beside the one that speaks for it, and is refused.
    pub is_doubled: bool,
    /// Areas in which such a process stands, by its own word, as long as it is heard; one that was found, also when it is silent; and those of
    /// one before, if the robot has started anew elsewhere.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub second_in: Vec<String>,
    /// How often one was found.
    pub doubled: u64,
    /// What kind of robot it is, by its own word.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub factsheet: Option<Factsheet>,
}

/// Everything.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Status {
    /// Number of this start of the mediator.
    pub epoch: u64,
    /// Robots follow another mediator, and this one grants nothing.
    #[serde(default)]
    pub stands_by: bool,
    /// Robots that must say where they stand before anything is granted.
    pub awaited: Vec<String>,
    /// Areas, in the order of the site file.
    pub areas: Vec<AreaStatus>,
    /// Robots, in the order of the site file.
    pub robots: Vec<RobotStatus>,
    /// Coordinations: the last ones that are over, then those that run.
    pub coordinations: Vec<CoordinationStatus>,
}

impl View<'_> {
    /// How everything stands.
    pub(crate) fn status(&self) -> Status {
        let running = { self.coordinations.instances() }
            .map(|instance| CoordinationStatus::of(instance, self.names, self.now_ns));
        Status {
            epoch: self.sessions.epoch,
            stands_by: self.peers.stands_by,
            awaited: { self.sessions.awaited().iter() }
                .map(|&robot| self.names.robot_id(robot))
                .collect(),
            areas: (0..self.areas.len())
                .map(|area| self.area_status(area))
                .collect(),
            robots: (0..self.names.robots().len())
                .map(|robot| self.robot_status(robot))
                .collect(),
            coordinations: { self.coordinations.over().cloned() }
                .chain(running)
                .collect(),
        }
    }

    fn area_status(&self, index: usize) -> AreaStatus {
        let area = self.areas.area(index);
        let name = |robot: usize| self.names.robot_id(robot);
        let claim = |robot: usize| self.areas.robot(robot).claim(index);
        let occupant = |robot: usize| self.areas.robot(robot);
        let (own, seconds) = self.bodies_in(index);
        let (holders, standing): (Vec<usize>, Vec<usize>) =
            { own.iter() }.partition(|&&robot| occupant(robot).holds(index));
        AreaStatus {
            id: self.names.area_id(index),
            capacity: area.capacity,
            fence: area.fence,
            holders: { holders.into_iter() }
                .map(|robot| (name(robot), claim(robot).map_or(0, |claim| claim.fence)))
                .collect(),
            standing: standing.into_iter().map(name).collect(),
            blocked: own.iter().any(|&robot| !self.sessions.is_heard(robot)) || { seconds.iter() }
                .any(|&robot| occupant(robot).seconds.are_silent_in(index, self.now_ns)),
            seconds: seconds.into_iter().map(name).collect(),
            kept_for: { self.coordinations.kept(index).into_iter() }
                .map(name)
                .collect(),
            waiting: area.queue.iter().map(|&robot| name(robot)).collect(),
            closed: self.areas.is_closed(index),
            closed_by: area.closed.clone(),
        }
    }

    fn robot_status(&self, robot: usize) -> RobotStatus {
        let (name, session) = (&self.names.robots()[robot], self.sessions.robot(robot));
        let occupant = self.areas.robot(robot);
        RobotStatus {
            id: name.id.clone(),
            role: name.role.clone(),
            session: session.number,
            heard: session.is_heard(),
            reports: self.peers.is_heard(robot, self.now_ns),
            located: occupant.located,
            age_ms: self.now_ns.saturating_sub(session.heard_ns) / 1_000_000,
            holds: (0..self.areas.len())
                .filter(|&area| occupant.holds(area))
                .map(|area| self.names.area_id(area))
                .collect(),
            waits: { occupant.waits() }
                .map(|area| (self.names.area_id(area), self.explain(robot, area)))
                .collect(),
            refusal: { session.refused.as_ref() }.map_or_else(String::new, |(_, why)| why.clone()),
            is_doubled: self.sessions.is_doubled(robot, self.now_ns),
            second_in: { occupant.seconds.areas().into_iter() }
                .map(|area| self.names.area_id(area))
                .collect(),
            doubled: session.doubled,
            factsheet: session.factsheet.clone(),
        }
    }
}
