//! What goes into a navigation step and what comes out of it.

use crate::borders::AreaSet;
use crate::localisation::{PoseCounters, ScanVerdict, WallsOutcome};
use crate::odometry::Odometry;
use crate::perception::corridor::CorridorEstimate;
use crate::perception::lane_end::LaneEndEstimate;
use crate::scan::AlignedScan;
use crate::schedule::Hold;
use crate::tubes::Room;
use coordination::event::EventId;
use coordination::fsm::StateId;
use description::areas::AreaIndex;
use description::geometry::{MotionCommand, Pose2, Twist2};

/// Events that one step can report.
pub const MAX_EVENTS: usize = 16;

/// What a teleoperator wants.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ByHand {
    /// The motion. This robot turns only while it rolls: a turn without speed is a wish to stand.
    pub wish: Twist2,
    /// No faster than this,
    pub limit_m_s: f64,
    /// and than this where the robot does not know its place, so that borders are no help.
    pub creep_m_s: f64,
    /// Somebody sees to it that the robot enters no area that others use, while it does not know its place.
    pub without_borders: bool,
}

/// What a step needs.
#[derive(Clone, Copy, Debug)]
pub struct NavigationInput<'a> {
    /// Monotonic time.
    pub now_ns: u64,
    /// The latest aligned scan; one that was seen before is not used again.
    pub scan: Option<&'a AlignedScan>,
    /// The latest dead reckoning.
    pub odometry: &'a Odometry,
    /// Nobody knows where the robot stands: its pose says nothing of what is in view.
    pub lost: bool,
    /// `false`: everything goes on, but the command is to stand.
    pub motion_allowed: bool,
    /// Somebody drives the robot by hand, and wants this.
    pub by_hand: Option<ByHand>,
    /// Areas that the robot may be in; [`AreaSet::ALL`] where areas are not managed.
    pub allowed: AreaSet,
}

/// A short list of events, without allocation.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct EventList {
    events: [EventId; MAX_EVENTS],
    len: usize,
}

impl Default for EventList {
    fn default() -> Self {
        Self {
            events: [EventId(0); MAX_EVENTS],
            len: 0,
        }
    }
}

impl EventList {
    /// The events in their order.
    #[must_use]
    pub fn as_slice(&self) -> &[EventId] {
        &self.events[..self.len]
    }

    /// Adds one; `false` when the list is full.
    pub(super) fn push(&mut self, event: EventId) -> bool {
        let Some(place) = self.events.get_mut(self.len) else {
            return false;
        };
        *place = event;
        self.len += 1;
        true
    }
}

/// Counts since the start.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct NavigationCounters {
    /// Steps made.
    pub steps: u64,
    /// Scans used.
    pub scans: u64,
    /// Scans that were older than the one before, or came from somewhere else than odometry knows.
    pub scans_refused: u64,
    /// Scans that showed nothing where the map has walls.
    pub scans_blind: u64,
    /// Events that found a list full.
    pub events_lost: u64,
    /// Times that the search for the corridor was restarted.
    pub corridor_restarts: u64,
    /// What became of the pose's corrections.
    pub pose: PoseCounters,
}

/// What the newest scan says of the pose.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PoseCheck {
    /// What it did for the pose.
    pub verdict: ScanVerdict,
    /// Walls that were found where the pose has them.
    pub agreeing: u32,
    /// Walls that were found too far from where the pose has them, and walls that the scan looks through.
    pub contradicting: u32,
}

impl PoseCheck {
    /// By a scan that showed at most one wall.
    pub(super) fn of(verdict: ScanVerdict) -> Self {
        Self {
            verdict,
            agreeing: u32::from(verdict == ScanVerdict::Corrected),
            contradicting: u32::from(verdict == ScanVerdict::Refused),
        }
    }
}

impl From<WallsOutcome> for PoseCheck {
    fn from(walls: WallsOutcome) -> Self {
        Self {
            verdict: walls.verdict,
            agreeing: walls.corrected,
            contradicting: walls.refused + walls.beams.walls_through,
        }
    }
}

/// What a step says.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NavigationOutput {
    /// Time of the step.
    pub now_ns: u64,
    /// The motion to make.
    pub command: MotionCommand,
    /// `base_link` in `map`.
    pub pose: Pose2,
    /// Of (x, y, θ), row by row.
    pub covariance: [[f64; 3]; 3],
    /// Standard deviation of the position in its worst direction.
    pub position_std_m: f64,
    /// The machine's state after the step.
    pub state: StateId,
    /// The state's area.
    pub area: Option<AreaIndex>,
    /// Index of the skill that runs.
    pub skill: usize,
    /// Of `base_link` from the path of the controller, positive to the left.
    pub lateral_error_m: f64,
    /// Of `base_link` from the direction of that path.
    pub heading_error_rad: f64,
    /// How far from that path the state's area, and what watches for deviation, let it be.
    pub room: Room,
    /// The corridor, when it is tracked.
    pub corridor: Option<CorridorEstimate>,
    /// The lane's end, when it is looked for and was found.
    pub lane_end: Option<LaneEndEstimate>,
    /// Monitors that fired in this step.
    pub events: EventList,
    /// Outputs that the machine fired in this step.
    pub outputs: EventList,
    /// The state, and with it the schedule, changed in this step.
    pub schedule_changed: bool,
    /// The controller has finished its manoeuvre.
    pub manoeuvre_done: bool,
    /// The pose is not good enough to drive by: the command is to stand.
    pub pose_uncertain: bool,
    /// The newest scan shows nothing where the map has walls: it is no view of the floor.
    pub blind: bool,
    /// What the newest scan says of the pose; `None` before the first one since the robot was put there.
    pub check: Option<PoseCheck>,
    /// Farther from the path than the area allows.
    pub deviation_exceeded: bool,
    /// Why the command is to stand although the skill wants to move, or cannot do what it should.
    pub hold: Option<Hold>,
    /// The area that is not allowed and that the robot slows down or waits for, or stands in.
    pub waiting_for: Option<AreaIndex>,
    /// Way left before the footprint (with its margins) would enter an area that is not allowed, when that is within
    /// the stopping distance on the planned path.
    pub border_distance_m: Option<f64>,
    /// Counts since the start.
    pub counters: NavigationCounters,
}
