//! What a site file holds, once it is read and valid: the semantic map, the
//! skills, the state machines, and which robots drive there.

use std::collections::BTreeMap;

use crate::geometry::{PoseConfig, Rect};
use crate::origin::Origin;

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
}

impl Manoeuvre {
    /// The name in files.
    pub const fn name(self) -> &'static str {
        match self {
            Manoeuvre::Forward => "forward",
            Manoeuvre::UTurn => "u-turn",
            Manoeuvre::Stop => "stop",
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
}

impl Feature {
    /// The name in files.
    pub const fn name(self) -> &'static str {
        match self {
            Feature::Corridor => "corridor",
            Feature::LaneEnd => "lane-end",
        }
    }
}

/// `[monitors.<event>]`: a condition, and the event raised when it becomes true.
#[derive(Clone, Debug, PartialEq)]
pub struct Monitor {
    /// The event.
    pub event: String,
    /// The condition.
    pub kind: MonitorKind,
}

/// A monitor's condition.
#[derive(Clone, Debug, PartialEq)]
pub enum MonitorKind {
    /// `base_link` has come into a region.
    RegionReached {
        /// Where the region is.
        region: Rect,
        /// What the file called it.
        of: RegionRef,
    },
    /// A feature's estimate has stayed good.
    EstimateStable {
        /// Which feature.
        feature: Feature,
        /// For this many scans in a row.
        scans: u32,
        /// Standard deviation at most this.
        max_std_m: f64,
    },
    /// The skill's controller has finished.
    ManoeuvreDone,
    /// `base_link` is too far from the lane's centre.
    Deviation {
        /// How far; without a number, the area's own limit.
        limit_m: Option<f64>,
    },
}

/// What a region is taken from.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum RegionRef {
    /// This area.
    Area(String),
    /// This perception zone.
    Zone(String),
    /// A rectangle of its own.
    Own,
}

/// `[skills.<id>]`: what runs together.
#[derive(Clone, Debug, PartialEq)]
pub struct SkillConfig {
    /// Unique among skills.
    pub id: String,
    /// What moves the robot.
    pub controller: ControllerConfig,
    /// The perception kind that runs.
    pub perception: String,
    /// The monitors that run, by event.
    pub monitors: Vec<String>,
}

/// A controller with its parameters.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ControllerConfig {
    /// Keeps on the area's lane, by the corridor's walls.
    Corridor,
    /// The same, and is done at this distance from `base_link` to the lane's end wall.
    EndOfLane {
        /// The distance.
        distance_m: f64,
    },
    /// Half a circle.
    UTurn {
        /// To which side.
        direction: TurnDirection,
        /// Of `base_link`'s path.
        radius_m: f64,
    },
    /// Stands still.
    Stop,
}

impl ControllerConfig {
    /// The name in files.
    pub const fn name(&self) -> &'static str {
        match self {
            ControllerConfig::Corridor => "corridor",
            ControllerConfig::EndOfLane { .. } => "end-of-lane",
            ControllerConfig::UTurn { .. } => "u-turn",
            ControllerConfig::Stop => "stop",
        }
    }
}

/// To which side a robot turns.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TurnDirection {
    /// Counter-clockwise.
    Left,
    /// Clockwise.
    Right,
}

/// `[fsm.<role>]`: a Mealy machine.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct FsmConfig {
    /// The first state, unless a robot's entry names another.
    pub initial: String,
    /// Events that no monitor raises: they come from an operator or the network.
    pub external: Vec<String>,
    /// Its states.
    pub states: Vec<FsmState>,
    /// Its transitions; at most one for a state and an event.
    pub transitions: Vec<FsmTransition>,
}

/// `[fsm.<role>.states.<name>]`
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct FsmState {
    /// Unique in the machine.
    pub name: String,
    /// The area that the state is about.
    pub area: String,
    /// The skill that runs in it.
    pub skill: String,
}

/// One entry of `transitions`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct FsmTransition {
    /// In this state,
    pub from: String,
    /// on this event,
    pub on: String,
    /// go to this state
    pub to: String,
    /// and raise these events.
    pub outputs: Vec<String>,
}

/// `[robots.<id>]`
#[derive(Clone, Debug, PartialEq)]
pub struct SiteRobot {
    /// Which state machine it runs.
    pub role: String,
    /// Where it starts.
    pub start: PoseConfig,
    /// In which state; by default the machine's initial one.
    pub start_state: Option<String>,
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

impl FsmConfig {
    /// The state with this name.
    pub fn state(&self, name: &str) -> Option<&FsmState> {
        self.states.iter().find(|state| state.name == name)
    }
}
