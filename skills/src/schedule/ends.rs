//! Controllers that end at a place: stops, docks and creeps.

use super::manoeuvres::{Case, Manoeuvres, Plan, finite, parameter, positive};
use super::room::border_ahead_m;
use super::{Controller, ScheduleError, StopPlace, StopTarget};
use crate::control::{CREEP_SPEED_M_S, MAX_BACKWARD_M_S};
use crate::map::LaneGeometry;
use description::geometry::{Pose2, wrap_angle};

/// A stop pose is turned from its lane by no more.
const STOP_HEADING_RAD: f64 = 0.2;
/// The lidar must see a wall to dock at: no closer than this to the front.
const NEAREST_DOCK_M: f64 = 0.05;

impl Manoeuvres<'_> {
    pub(super) fn stop_at(&self, case: &Case, target: &StopTarget) -> Result<Plan, ScheduleError> {
        let index = case.lane()?;
        let lane = self.lane(index);
        let place = match target {
            StopTarget::Instructed => StopPlace::Instructed,
            StopTarget::BeforeArea { area, margin_m } => {
                let margin_m = *margin_m;
                let sound = margin_m.is_finite() && margin_m >= 0.0;
                parameter(case.skill, "margin", "zero or more", margin_m, sound)?;
                let found = self.map().area_index(area);
                let region = found.ok_or_else(|| ScheduleError::Unknown {
                    kind: "skill",
                    id: case.skill.id.clone(),
                    wanted: "area",
                    name: area.clone(),
                })?;
                let region = &self.map().areas()[region].region;
                let footprint = &self.robot.footprint;
                let along_m = border_ahead_m(&lane.line, region, footprint)
                    .filter(|along_m| *along_m - margin_m - footprint.front_m > 0.0)
                    .ok_or_else(|| {
                        case.impossible(format!(
                            "area `{area}` does not begin ahead on lane `{}`, or leaves no room to stop before it",
                            lane.id
                        ))
                    })?;
                StopPlace::Border { along_m, margin_m }
            }
            StopTarget::Pose(pose) => {
                let (along_m, offset_m) = self.place_on(case, lane, *pose)?;
                self.check_offset(case, index, offset_m)?;
                StopPlace::Pose { along_m, offset_m }
            }
        };
        Ok(self.on_lane(case, Controller::StopAt(place), Some(index)))
    }

    /// Along and beside the lane; the pose must lie there, in the lane's direction.
    fn place_on(
        &self,
        case: &Case,
        lane: &LaneGeometry,
        pose: Pose2,
    ) -> Result<(f64, f64), ScheduleError> {
        if !pose.is_finite() {
            return Err(case.impossible("its stop pose is not finite"));
        }
        let along_m = lane.line.along_m(pose.position());
        let offset_m = lane.line.lateral_m(pose.position());
        let off_rad = wrap_angle(pose.theta_rad - lane.direction_rad);
        let area = self.graph.of(case.state).area;
        let beside_m = area.map_or(f64::INFINITY, |area| {
            self.map().areas()[area].deviation_limit_m
        });
        if off_rad.abs() > STOP_HEADING_RAD || offset_m.abs() > beside_m || along_m < 0.0 {
            return Err(case.impossible(format!(
                "its stop pose lies {along_m:.2} m along lane `{}`, {offset_m:.2} m beside it and {:.0}° off, expected 0 m or more, {beside_m} m and {:.0}° or less",
                lane.id,
                off_rad.to_degrees(),
                STOP_HEADING_RAD.to_degrees()
            )));
        }
        Ok((along_m, offset_m))
    }

    pub(super) fn dock(&self, case: &Case, distance_m: f64) -> Result<Plan, ScheduleError> {
        positive(case.skill, "distance", distance_m)?;
        let lane = case.lane()?;
        if self.lane(lane).end.is_none() {
            return Err(case.no_lane("a lane that a wall closes, to dock at"));
        }
        if !(case.skill.tracks.lane_end || case.skill.searches.lane_end) {
            return Err(case.impossible(format!(
                "skill `{}` docks at a wall and does not look for the lane's end",
                case.skill.id
            )));
        }
        if distance_m < NEAREST_DOCK_M {
            return Err(case.impossible(format!(
                "docking {distance_m} m before a wall is closer than the {NEAREST_DOCK_M} m that can be measured"
            )));
        }
        Ok(self.on_lane(case, Controller::Dock { distance_m }, Some(lane)))
    }

    pub(super) fn creep(&self, case: &Case, distance_m: f64) -> Result<Plan, ScheduleError> {
        finite(case.skill, "distance", distance_m)?;
        parameter(
            case.skill,
            "distance",
            "other than zero",
            distance_m,
            distance_m != 0.0,
        )?;
        let own_m_s = case.skill.speed_m_s.unwrap_or(CREEP_SPEED_M_S);
        if distance_m < 0.0 && own_m_s > MAX_BACKWARD_M_S {
            return Err(case.impossible(format!(
                "backward at {own_m_s} m/s is faster than the {MAX_BACKWARD_M_S} m/s that a robot may drive blindly"
            )));
        }
        let plan = self.on_lane(case, Controller::Creep { distance_m }, case.lane);
        Ok(Plan {
            speed_limit_m_s: plan.speed_limit_m_s.min(own_m_s),
            ..plan
        })
    }
}
