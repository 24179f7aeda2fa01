//! What a site file says about monitors and skills.

use crate::geometry::{PoseConfig, Rect};

use super::Feature;

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
    /// The state was entered this long ago.
    After {
        /// How long.
        after_s: f64,
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
    /// Fastest speed of this skill; the area's and the robot's limits hold as well.
    pub speed_m_s: Option<f64>,
    /// The perception kind that runs.
    pub perception: String,
    /// The monitors that run, by event.
    pub monitors: Vec<String>,
}

/// A controller with its parameters.
#[derive(Clone, Debug, PartialEq)]
pub enum ControllerConfig {
    /// Keeps on the state's lane, by the corridor's walls.
    Corridor {
        /// To the left of the lane; negative to its right.
        offset_m: f64,
    },
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
    /// From beside the state's lane onto it; done when the robot drives on it.
    Shift {
        /// To the left of the lane; negative to its right.
        offset_m: f64,
        /// Length of lane that the change may take.
        within_m: f64,
    },
    /// From the lane of the state before onto the state's lane: left, right or straight
    /// on, as the lanes lie; done when the robot drives on it.
    Turn {
        /// Of `base_link`'s path where it turns.
        radius_m: f64,
    },
    /// Along the state's lane to a place; done when the robot stands there.
    StopAt {
        /// Where.
        place: StopPlace,
    },
    /// Towards the end wall of the state's lane, as the lidar sees it; done when the
    /// robot stands.
    Dock {
        /// From the front of the footprint to the wall.
        distance_m: f64,
    },
    /// A short way along the state's lane, heading kept; done when it is driven.
    Creep {
        /// How far; negative: backward.
        distance_m: f64,
    },
}

/// Where a robot stops.
#[derive(Clone, Debug, PartialEq)]
pub enum StopPlace {
    /// Before it enters an area.
    BeforeArea {
        /// The area.
        area: String,
        /// From the front of the footprint to the area's border.
        margin_m: f64,
    },
    /// With `base_link` at a pose in `map`.
    Pose(PoseConfig),
    /// At the pose that comes with the event that starts the state.
    Instructed,
}

impl ControllerConfig {
    /// The name in files.
    pub const fn name(&self) -> &'static str {
        match self {
            ControllerConfig::Corridor { .. } => "corridor",
            ControllerConfig::EndOfLane { .. } => "end-of-lane",
            ControllerConfig::UTurn { .. } => "u-turn",
            ControllerConfig::Stop => "stop",
            ControllerConfig::Shift { .. } => "shift",
            ControllerConfig::Turn { .. } => "turn",
            ControllerConfig::StopAt { .. } => "stop-at",
            ControllerConfig::Dock { .. } => "dock",
            ControllerConfig::Creep { .. } => "creep",
        }
    }

    /// Whether it comes to an end by itself, so that a monitor can see it done.
    pub const fn ends(&self) -> bool {
        !matches!(
            self,
            ControllerConfig::Corridor { .. } | ControllerConfig::Stop
        )
    }

    /// Whether it keeps along the state's lane.
    pub const fn follows_lane(&self) -> bool {
        !matches!(
            self,
            ControllerConfig::UTurn { .. } | ControllerConfig::Turn { .. } | ControllerConfig::Stop
        )
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
