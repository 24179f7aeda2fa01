//! The present schedule's controller: steering, speed and end.

use super::output::NavigationInput;
use super::state::{Navigator, end_wall};
use crate::control::{PathError, Steer, Stopping};
use crate::schedule::Schedule;
use crate::schedule::controllers::motion::{Motion, Start, pose_error};
use crate::schedule::controllers::pace::{Hold, Pace, Progress};
use crate::schedule::controllers::stop_at::InstructedStop;
use description::geometry::Pose2;

/// A lane end known worse than this is taken from the map instead.
const LANE_END_STD_M: f64 = 0.15;
/// Docking needs at most this standard deviation, in this many scans in a row.
const DOCK_STD_M: f64 = 0.03;
const DOCK_SCANS: u32 = 3;
/// Slower than this is standing.
const STANDING_M_S: f64 = 0.01;

/// What a controller says.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Control {
    pub(super) steer: Steer,
    /// Wanted speed, negative backward; approached at the ramp's slopes.
    pub(super) wish_m_s: f64,
    /// No faster than this, at once.
    pub(super) safe_m_s: f64,
    /// Way that remains.
    pub(super) left_m: f64,
    pub(super) done: bool,
    pub(super) hold: Option<Hold>,
}

impl Navigator {
    /// The motion that the present schedule's controller wants.
    pub(super) fn control(&mut self, input: &NavigationInput, dt_s: f64) -> Control {
        let pose = self.pose.pose();
        let speed_m_s = self.speed_m_s(input);
        let schedule = &self.schedules[self.machine.state().index()];
        let error = self.lane_error(schedule);
        let limit_m_s = schedule
            .speed_limit_m_s
            .min(self.parameters.speed_limit_m_s.unwrap_or(f64::INFINITY));
        let (end_m, end_measured) = self.end_distance_m(schedule);
        let lane = schedule.lane.map(|lane| &self.map.lanes()[lane]);
        let along_std_m = lane.map_or(0.0, |lane| self.pose.std_along_m(lane.direction_rad));
        let steer = self.motion.steer(pose, error, speed_m_s.abs(), &self.gains);
        let now = Progress {
            pose,
            lane,
            end_wall: end_wall(&self.map, schedule),
            end_m,
            end_measured,
            margin_m: self.gains.border_sigma * along_std_m + self.gains.map_error_m,
            speed_m_s,
            limit_m_s,
            instructed: self.parameters.stop_at.is_some(),
            dt_s,
            footprint: &self.footprint,
            gains: &self.gains,
        };
        let behaviour = schedule.controller.behaviour();
        let mut pace = behaviour.pace(&self.motion, &mut self.stopping, &now);
        let stands = speed_m_s.abs() < STANDING_M_S && self.instructed.is_none();
        if stands
            && pace.hold == Some(Hold::StopPose)
            && let Some(back) = behaviour.back_up(&now)
        {
            self.motion = back;
            self.stopping = Stopping::default();
        }
        if let Some(stop) = self.instructed {
            pace = pace.and(stop.pace(&self.motion, &mut self.halting, &now));
        }
        if self.parameters.speed_limit_m_s == Some(0.0) {
            pace = pace.and(Pace::standing(Hold::SpeedLimit));
        }
        let wish_m_s = steer.direction * limit_m_s * steer.speed_share;
        if !(steer.curvature_1_m.is_finite() && wish_m_s.is_finite()) {
            return Control {
                hold: Some(Hold::PoseUncertain),
                ..Control::default()
            };
        }
        Control {
            steer,
            wish_m_s,
            safe_m_s: pace.speed_m_s,
            left_m: pace.left_m,
            done: pace.done || matches!(self.motion, Motion::Still),
            hold: pace.hold,
        }
    }

    /// The path of the machine's state begins at the present pose.
    pub(super) fn begin_motion(&mut self) {
        self.begin_motion_at(self.pose.pose());
    }

    /// The path of the machine's state begins somewhere, and is driven on from where the robot is.
    pub(super) fn begin_motion_at(&mut self, began: Pose2) {
        let schedule = &self.schedules[self.machine.state().index()];
        let lane = |index: Option<usize>| index.map(|index| &self.map.lanes()[index].line);
        let start = Start {
            onto: lane(schedule.lane),
            from: lane(schedule.from_lane),
            pose: began,
            max_curvature_1_m: self.gains.max_curvature_1_m,
        };
        self.motion = schedule.controller.behaviour().motion(&start);
        self.began = began;
        let pose = self.pose.pose();
        if pose != began {
            self.motion.go_on_at(pose);
        }
        self.stopping = Stopping::default();
        self.begin_parameters();
    }

    /// The parameters of the state were exchanged.
    pub(super) fn begin_parameters(&mut self) {
        let schedule = &self.schedules[self.machine.state().index()];
        self.halting = Stopping::default();
        self.instructed = None;
        let own_m = schedule.controller.behaviour().offset_m();
        self.motion.keep_beside(own_m);
        if let Some(stop) = self.parameters.stop_at {
            let lane = schedule.lane.map(|lane| &self.map.lanes()[lane]);
            let stop = InstructedStop::on(&self.motion, lane, stop);
            if let InstructedStop::Place { aside_m, .. } = stop {
                self.motion.keep_beside(aside_m);
            }
            self.instructed = Some(stop);
        }
    }

    /// Relative to the schedule's lane: by the corridor while it is known well, by the pose otherwise.
    fn lane_error(&self, schedule: &Schedule) -> PathError {
        let Some(lane) = schedule.lane.map(|lane| &self.map.lanes()[lane]) else {
            return PathError::default();
        };
        let corridor = self.corridor.estimate();
        match corridor.filter(|estimate| schedule.features.corridor && estimate.usable) {
            Some(estimate) => PathError {
                lateral_m: estimate.lateral_m,
                heading_rad: estimate.heading_rad,
            },
            None => pose_error(lane, self.pose.pose()),
        }
    }

    /// From `base_link` to the lane's end wall, and whether the lidar has measured it well.
    fn end_distance_m(&self, schedule: &Schedule) -> (f64, bool) {
        let tracked = self
            .lane_end
            .estimate()
            .filter(|_| schedule.features.lane_end);
        let measured =
            tracked.is_some_and(|end| end.std_m < DOCK_STD_M && end.consistent_scans >= DOCK_SCANS);
        if let Some(end) = tracked.filter(|end| end.std_m < LANE_END_STD_M) {
            return (end.distance_m, measured);
        }
        let mapped_m = end_wall(&self.map, schedule).map_or(0.0, |wall| {
            wall.line.lateral_m(self.pose.pose().position()).abs()
        });
        (mapped_m, false)
    }
}
