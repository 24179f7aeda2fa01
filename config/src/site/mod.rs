//! What a site file holds, once it is read and valid: the semantic map, the
//! skills, the state machines, and which robots drive there.

mod coordination;
mod fsm;
mod skills;

use std::collections::BTreeMap;

use crate::geometry::Rect;
use crate::origin::Origin;

pub use coordination::{
    CastConfig, CoordinationConfig, FlagMeaning, PreemptConfig, RoleConfig, SituationConfig,
    YieldConfig,
};
pub use fsm::{FsmConfig, FsmState, FsmTransition, SiteRobot};
pub use skills::{
    ControllerConfig, Monitor, MonitorKind, RegionRef, SkillConfig, StopPlace, TurnDirection,
};

/// A site. All lengths are metres in the `map` frame, x east, y north.
#[derive(Clone, Debug)]
pub struct SiteConfig {
    /// The site's name.
    pub name: String,
    /// Whether a mediator grants areas; without one everything is granted.
    pub areas_managed: bool,
    /// Solid walls, as the lidar sees them.
    pub walls: Vec<Wall>,
    /// Directed centre lines to drive on.
    pub lanes: Vec<Lane>,
    /// The control layer: areas that a robot owns while it is in them.
    pub areas: Vec<Area>,
    /// The perception layer's zones.
    pub perception: Vec<PerceptionZone>,
    /// What is perceived in a zone of each kind.
    pub perception_kinds: BTreeMap<String, PerceptionKind>,
    /// What raises events.
    pub monitors: Vec<Monitor>,
    /// Schedules: perception, controller and monitors that run together.
    pub skills: Vec<SkillConfig>,
    /// A state machine for each role.
    pub fsm: BTreeMap<String, FsmConfig>,
    /// The robots, by identity.
    pub robots: BTreeMap<String, SiteRobot>,
    /// What the mediator knows of a role.
    pub roles: BTreeMap<String, RoleConfig>,
    /// When robots are coordinated.
    pub coordinations: BTreeMap<String, CoordinationConfig>,
    /// Where each value was written.
    pub origin: Origin,
}

/// `[walls.<id>]`: a straight wall.
#[derive(Clone, Debug, PartialEq)]
pub struct Wall {
    /// Unique among walls.
    pub id: String,
    /// One end (x, y).
    pub from_m: [f64; 2],
    /// The other end (x, y).
    pub to_m: [f64; 2],
}

/// `[lanes.<id>]`: a directed centre line.
#[derive(Clone, Debug, PartialEq)]
pub struct Lane {
    /// Unique among lanes.
    pub id: String,
    /// Where it starts (x, y).
    pub from_m: [f64; 2],
    /// Where it ends (x, y).
    pub to_m: [f64; 2],
    /// The wall that closes the lane ahead: the feature "lane end".
    pub end_wall: Option<String>,
}

/// `[areas.<id>]`: a piece of floor that is owned as a whole.
#[derive(Clone, Debug, PartialEq)]
pub struct Area {
    /// Unique among areas.
    pub id: String,
    /// Where it is.
    pub region: Rect,
    /// The lane that runs through it.
    pub lane: Option<String>,
    /// How many robots it holds.
    pub capacity: u32,
    /// What a robot does in it, and within which limits.
    pub control: ControlLayer,
}

/// What an area expects of a robot's control.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ControlLayer {
    /// The manoeuvre.
    pub manoeuvre: Manoeuvre,
    /// Fastest speed.
    pub speed_limit_m_s: f64,
    /// Farthest from the lane's centre.
    pub deviation_limit_m: f64,
}

/// What a robot does in an area.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Manoeuvre {
    /// Drives along the lane, or to its end.
    Forward,
    /// Turns round.
    UTurn,
    /// Drives in, stops, drives out.
    Stop,
    /// Crosses a junction: turns from one lane onto another, or goes straight on.
    Turn,
    /// Drives up to a wall, and back from it.
    Dock,
    /// What each state says: an area for several manoeuvres.
    Any,
}

impl Manoeuvre {
    /// The name in files.
    pub const fn name(self) -> &'static str {
        match self {
            Manoeuvre::Forward => "forward",
            Manoeuvre::UTurn => "u-turn",
            Manoeuvre::Stop => "stop",
            Manoeuvre::Turn => "turn",
            Manoeuvre::Dock => "dock",
            Manoeuvre::Any => "any",
        }
    }
}

/// `[perception.zones.<id>]`
#[derive(Clone, Debug, PartialEq)]
pub struct PerceptionZone {
    /// Unique among zones.
    pub id: String,
    /// Which of the perception kinds.
    pub kind: String,
    /// Where it is.
    pub region: Rect,
}

/// `[perception.kinds.<kind>]`
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct PerceptionKind {
    /// Features that are tracked and correct the pose.
    pub tracks: Vec<Feature>,
    /// Features that are looked for, until an estimate is stable.
    pub searches: Vec<Feature>,
}

/// What perception can find in a scan.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Feature {
    /// The two side walls: orientation and lateral offset.
    Corridor,
    /// The wall that closes a lane: distance ahead.
    LaneEnd,
    /// Every wall of the map that is in view: they correct the pose.
    Walls,
}

impl Feature {
    /// The name in files.
    pub const fn name(self) -> &'static str {
        match self {
            Feature::Corridor => "corridor",
            Feature::LaneEnd => "lane-end",
            Feature::Walls => "walls",
        }
    }
}

impl SiteConfig {
    /// The wall with this id.
    pub fn wall(&self, id: &str) -> Option<&Wall> {
        self.walls.iter().find(|wall| wall.id == id)
    }

    /// The lane with this id.
    pub fn lane(&self, id: &str) -> Option<&Lane> {
        self.lanes.iter().find(|lane| lane.id == id)
    }

    /// The area with this id.
    pub fn area(&self, id: &str) -> Option<&Area> {
        self.areas.iter().find(|area| area.id == id)
    }

    /// The first area that contains the point.
    pub fn area_at(&self, point_m: [f64; 2]) -> Option<&Area> {
        self.areas.iter().find(|area| area.region.contains(point_m))
    }

    /// The monitor that raises this event.
    pub fn monitor(&self, event: &str) -> Option<&Monitor> {
        self.monitors.iter().find(|monitor| monitor.event == event)
    }

    /// The skill with this id.
    pub fn skill(&self, id: &str) -> Option<&SkillConfig> {
        self.skills.iter().find(|skill| skill.id == id)
    }
}
