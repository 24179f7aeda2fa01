//! What a site says about skills, monitors and states, as plain data.

use crate::control::TurnDirection;
use crate::monitors::MonitorKind;
use crate::perception::FeatureSet;
use coordination::event::EventId;
use description::geometry::Pose2;

/// A controller by its parameters.
#[derive(Clone, Debug, PartialEq)]
pub enum ControllerSetup {
    /// Keeps on the lane of the state's area, or beside it.
    Corridor {
        /// Of the path from the lane's centre, positive to the left.
        offset_m: f64,
    },
    /// Keeps on the lane, up to a distance from the wall at its end.
    EndOfLane {
        /// From `base_link` to the wall.
        distance_m: f64,
        /// Speed to have there. By default what the following states allow, 0 when all of them stand still.
        exit_speed_m_s: Option<f64>,
    },
    /// Half a turn onto a lane that runs the other way.
    UTurn {
        /// To which side.
        direction: TurnDirection,
        /// Of `base_link`'s path.
        radius_m: f64,
    },
    /// Changes onto the state's lane from a lane beside it.
    Shift {
        /// Of the path on the new lane from its centre, positive to the left.
        offset_m: f64,
        /// Length along the lane in which the change is made.
        within_m: f64,
    },
    /// At a junction: from the lane of the state before onto the state's lane. Left, right or straight follow from the
    /// two lanes.
    Turn {
        /// Of the curve that joins the lanes.
        radius_m: f64,
    },
    /// Keeps on the lane and stops.
    StopAt {
        /// Where.
        target: StopTarget,
    },
    /// Drives up to the wall at the lane's end, by what the lidar measures of it, and stops.
    Dock {
        /// From the front of the footprint to the wall.
        distance_m: f64,
    },
    /// Drives a short way along the direction of the state's lane (without one: of the robot), and stops.
    Creep {
        /// How far; negative: backward.
        distance_m: f64,
    },
    /// Stands still.
    Stop,
}

/// Where a robot stops on its lane.
#[derive(Clone, Debug, PartialEq)]
pub enum StopTarget {
    /// The whole footprint before the border of an area that lies ahead.
    BeforeArea {
        /// Name of the area.
        area: String,
        /// From the front of the footprint to the border; the uncertainty of the pose is added to it.
        margin_m: f64,
    },
    /// `base_link` at a pose in `map`, beside the lane or on it and in its direction.
    Pose(Pose2),
    /// At the pose that comes with the instruction that entered the state.
    Instructed,
}

/// A monitor by its name.
#[derive(Clone, Debug, PartialEq)]
pub struct MonitorSetup {
    /// Unique among monitors.
    pub id: String,
    /// Raised when the condition becomes true.
    pub event: EventId,
    /// The condition.
    pub kind: MonitorKind,
}

/// What runs together.
#[derive(Clone, Debug, PartialEq)]
pub struct SkillSetup {
    /// Unique among skills.
    pub id: String,
    /// What moves the robot.
    pub controller: ControllerSetup,
    /// The skill's own limit, below that of the area; always positive, also for backward motion.
    pub speed_m_s: Option<f64>,
    /// Features that correct the pose.
    pub tracks: FeatureSet,
    /// Features that are looked for, without correcting the pose.
    pub searches: FeatureSet,
    /// Monitors by name.
    pub monitors: Vec<String>,
}

/// What a state of the machine means.
#[derive(Clone, Debug, PartialEq)]
pub struct StateSetup {
    /// A state of the machine.
    pub name: String,
    /// The area that it is about.
    pub area: Option<String>,
    /// The lane to drive on, or onto, when it is not the area's.
    pub lane: Option<String>,
    /// The skill that runs.
    pub skill: String,
}
