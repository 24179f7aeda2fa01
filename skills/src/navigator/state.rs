//! What a navigator holds between two steps.

use super::instruction::{Inbox, Parameters};
use super::output::{NavigationCounters, NavigationInput, PoseCheck};
use crate::borders::BorderGuard;
use crate::control::{SpeedRamp, Stopping};
use crate::localisation::PoseFilter;
use crate::map::{LaneWall, SemanticMap};
use crate::perception::corridor::CorridorTracker;
use crate::perception::lane_end::LaneEndTracker;
use crate::perception::line::LineFitter;
use crate::perception::walls::WallMatcher;
use crate::schedule::Schedule;
use crate::schedule::controllers::motion::Motion;
use crate::schedule::controllers::stop_at::InstructedStop;
use coordination::event::EventTable;
use coordination::fsm::{Machine, StateId};
use description::geometry::{Footprint, Point2, Pose2};
use description::robot::Navigation;
use std::f64::consts::FRAC_PI_2;

/// A measured speed is clamped to this multiple of the robot's limit.
const BELIEVED_SPEED: f64 = 2.0;

/// The navigation of one robot.
#[derive(Clone, Debug)]
pub struct Navigator {
    pub(super) map: SemanticMap,
    pub(super) machine: Machine,
    pub(super) events: EventTable,
    pub(super) schedules: Vec<Schedule>,
    pub(super) skill_names: Vec<String>,
    pub(super) gains: Navigation,
    pub(super) pose: PoseFilter,
    pub(super) fitter: LineFitter,
    pub(super) points: Vec<Point2>,
    pub(super) corridor: CorridorTracker,
    pub(super) lane_end: LaneEndTracker,
    pub(super) matcher: WallMatcher,
    pub(super) guard: BorderGuard,
    pub(super) footprint: Footprint,
    pub(super) max_speed_m_s: f64,
    pub(super) motion: Motion,
    /// Where the path of the present state began.
    pub(super) began: Pose2,
    pub(super) stopping: Stopping,
    /// Where the instruction says to stop.
    pub(super) instructed: Option<InstructedStop>,
    pub(super) halting: Stopping,
    pub(super) ramp: SpeedRamp,
    pub(super) last_curvature_1_m: f64,
    pub(super) path: Vec<Pose2>,
    pub(super) path_step_m: f64,
    pub(super) inbox: Inbox,
    pub(super) parameters: Parameters,
    pub(super) in_state_s: f64,
    /// Somebody drives it by hand, or has, and nobody has sent it on since.
    pub(super) by_hand: bool,
    pub(super) last_step_ns: u64,
    pub(super) last_scan_ns: u64,
    /// The newest scan showed nothing where the map has walls.
    pub(super) blind: bool,
    /// What the newest scan says of the pose.
    pub(super) check: Option<PoseCheck>,
    pub(super) counters: NavigationCounters,
}

impl Navigator {
    /// The machine, for names.
    #[must_use]
    pub fn machine(&self) -> &Machine {
        &self.machine
    }

    /// The numbers of the events of monitors and machine.
    #[must_use]
    pub fn events(&self) -> &EventTable {
        &self.events
    }

    /// The map, for names.
    #[must_use]
    pub fn map(&self) -> &SemanticMap {
        &self.map
    }

    /// The name of a skill by its index.
    #[must_use]
    pub fn skill_name(&self, skill: usize) -> &str {
        self.skill_names.get(skill).map_or("?", String::as_str)
    }

    /// What runs in a state.
    #[must_use]
    pub fn schedule(&self, state: StateId) -> Option<&Schedule> {
        self.schedules.get(state.index())
    }

    /// What holds for the present state.
    #[must_use]
    pub fn parameters(&self) -> Parameters {
        self.parameters
    }

    /// Where the present controller is going to lead `base_link`, in `map`: poses at equal distances ahead (behind, when
    /// it creeps backward), up to where it stops. As of the last step.
    #[must_use]
    pub fn planned_path(&self) -> &[Pose2] {
        &self.path
    }

    /// The measured speed; 0 when it is not finite.
    pub(super) fn speed_m_s(&self, input: &NavigationInput) -> f64 {
        let most_m_s = BELIEVED_SPEED * self.max_speed_m_s;
        let speed_m_s = input.odometry.twist.v_m_s;
        if speed_m_s.is_finite() {
            speed_m_s.clamp(-most_m_s, most_m_s)
        } else {
            0.0
        }
    }

    pub(super) fn schedule_now(&self) -> &Schedule {
        &self.schedules[self.machine.state().index()]
    }

    /// The wall at the lane's end, see [`end_wall`].
    pub(super) fn end_wall(&self) -> Option<LaneWall> {
        end_wall(&self.map, self.schedule_now()).copied()
    }

    /// Uncertainty of the pose across a direction of `map`.
    pub(super) fn std_across_m(&self, direction_rad: f64) -> f64 {
        self.pose.std_along_m(direction_rad + FRAC_PI_2)
    }
}

/// The wall that closes the schedule's lane, or the lane that its U-turn leaves.
pub(super) fn end_wall<'a>(map: &'a SemanticMap, schedule: &Schedule) -> Option<&'a LaneWall> {
    schedule
        .end_lane
        .and_then(|lane| map.lanes()[lane].end.as_ref())
}
