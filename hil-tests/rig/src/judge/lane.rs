//! Whether a robot keeps to its lane and to the speed limits of areas.

use description::geometry::Point2;
use description::site::Area;
use sim::world::Truth;

use super::look::Robot;
use super::violations::Violations;
use crate::lanes::forward_lane;
use crate::scenario::Limits;
use crate::violation::ViolationKind;

/// A slower area's limit need not hold before its border: of all areas nearer than this the highest limit counts.
const NEXT_AREA_M: f64 = 0.35;

/// Watches one robot.
#[derive(Debug, Default)]
pub(super) struct Lane {
    /// Index of the area that was entered last.
    area: Option<usize>,
    max_lateral_error_m: f64,
    /// The same since it was last taken.
    recent_lateral_error_m: f64,
}

impl Lane {
    /// Largest lateral error so far.
    pub(super) fn max_lateral_error_m(&self) -> f64 {
        self.max_lateral_error_m
    }

    /// Largest lateral error since the last call.
    pub(super) fn take_lateral_error_m(&mut self) -> f64 {
        std::mem::take(&mut self.recent_lateral_error_m)
    }

    pub(super) fn judge(
        &mut self,
        robot: &Robot,
        limits: &Limits,
        truth: &Truth,
        violations: &mut Violations,
    ) {
        let at = Point2::new(truth.pose.x_m, truth.pose.y_m);
        let areas = &robot.site.areas;
        let here = areas.iter().position(|area| area.region.contains(at));
        self.area = here.or(self.area);
        let Some(area) = self.area.map(|index| &areas[index]) else {
            return;
        };
        if let Some(over) = limits.over_speed {
            judge_speed(robot, area, over, truth, violations);
        }
        let Some(lane) = forward_lane(&robot.site, area) else {
            return;
        };
        let lateral_m = lane.line.lateral_m(at);
        self.max_lateral_error_m = self.max_lateral_error_m.max(lateral_m.abs());
        self.recent_lateral_error_m = self.recent_lateral_error_m.max(lateral_m.abs());
        if let Some(most_m) = limits
            .lateral_error_m
            .filter(|most_m| lateral_m.abs() > *most_m)
        {
            let detail = format!("{lateral_m:.3} m off the lane, expected at most {most_m} m");
            violations.report(
                ViolationKind::LateralError,
                &robot.name,
                truth.time_ns,
                detail,
            );
        }
    }
}

fn judge_speed(robot: &Robot, area: &Area, over: f64, truth: &Truth, violations: &mut Violations) {
    let at = Point2::new(truth.pose.x_m, truth.pose.y_m);
    let speed_m_s = truth.twist.v_m_s.abs();
    let near = { robot.site.areas.iter() }
        .filter(|other| other.region.distance_m(at) < NEXT_AREA_M)
        .map(|other| other.control.speed_limit_m_s);
    let limit_m_s = near.fold(area.control.speed_limit_m_s, f64::max);
    if speed_m_s > limit_m_s * (1.0 + over) {
        let detail = format!(
            "{speed_m_s:.3} m/s in area {}, expected at most {limit_m_s} m/s",
            area.id
        );
        violations.report(ViolationKind::Speed, &robot.name, truth.time_ns, detail);
    }
}
