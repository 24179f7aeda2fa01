//! Whether a robot keeps to its lane and to the speed limits of areas.

use config::SiteConfig;
use description::geometry::Rect;
use description::site::Manoeuvre;
use sim::world::Truth;

use super::violations::Violations;
use crate::scenario::Limits;

/// Between two areas with different limits the slower one need not hold before its border: of areas nearer than this the
/// higher limit counts.
const NEXT_AREA_M: f64 = 0.35;

/// Watches one robot.
#[derive(Debug)]
pub(super) struct Lane {
    robot: String,
    areas: Vec<Area>,
    /// Index of the area that was entered last.
    area: Option<usize>,
    max_lateral_error_m: f64,
}

#[derive(Debug)]
struct Area {
    id: String,
    region: Rect,
    speed_limit_m_s: f64,
    /// Ends of the lane's centre, if the area is driven forward on a lane.
    lane: Option<([f64; 2], [f64; 2])>,
}

impl Lane {
    pub(super) fn new(robot: &str, site: &SiteConfig) -> Self {
        let areas = { site.areas.iter() }
            .map(|area| Area {
                id: area.id.clone(),
                region: area.region,
                speed_limit_m_s: area.control.speed_limit_m_s,
                lane: { area.lane.as_ref() }
                    .filter(|_| area.control.manoeuvre == Manoeuvre::Forward)
                    .and_then(|id| site.lane(id))
                    .map(|lane| (lane.line.a.xy_m(), lane.line.b.xy_m())),
            })
            .collect();
        Self {
            robot: robot.to_owned(),
            areas,
            area: None,
            max_lateral_error_m: 0.0,
        }
    }

    /// Largest lateral error so far.
    pub(super) fn max_lateral_error_m(&self) -> f64 {
        self.max_lateral_error_m
    }

    pub(super) fn judge(&mut self, limits: &Limits, truth: &Truth, violations: &mut Violations) {
        let here = { self.areas.iter() }.position(|area| distance_m(&area.region, truth) <= 0.0);
        self.area = here.or(self.area);
        let Some(area) = self.area.map(|index| &self.areas[index]) else {
            return;
        };
        if let Some(over) = limits.over_speed {
            self.judge_speed(area, over, truth, violations);
        }
        let Some((from_m, to_m)) = area.lane else {
            return;
        };
        let [dx, dy] = [0, 1].map(|axis| to_m[axis] - from_m[axis]);
        let lateral_m =
            ((truth.pose.y_m - from_m[1]) * dx - (truth.pose.x_m - from_m[0]) * dy) / dx.hypot(dy);
        self.max_lateral_error_m = self.max_lateral_error_m.max(lateral_m.abs());
        if let Some(most_m) = limits
            .lateral_error_m
            .filter(|most_m| lateral_m.abs() > *most_m)
        {
            let detail = format!("{lateral_m:.3} m off the lane, expected at most {most_m} m");
            violations.report("lateral-error", &self.robot, truth.time_ns, detail);
        }
    }

    fn judge_speed(&self, area: &Area, over: f64, truth: &Truth, violations: &mut Violations) {
        let speed_m_s = truth.twist.v_m_s.abs();
        let near = { self.areas.iter() }
            .filter(|other| distance_m(&other.region, truth) < NEXT_AREA_M)
            .map(|other| other.speed_limit_m_s);
        let limit_m_s = near.fold(area.speed_limit_m_s, f64::max);
        if speed_m_s > limit_m_s * (1.0 + over) {
            let detail = format!(
                "{speed_m_s:.3} m/s in area {}, expected at most {limit_m_s} m/s",
                area.id
            );
            violations.report("speed", &self.robot, truth.time_ns, detail);
        }
    }
}

/// Distance of `base_link` from a region, 0 inside.
fn distance_m(region: &Rect, truth: &Truth) -> f64 {
    let at_m = [truth.pose.x_m, truth.pose.y_m];
    let [x_m, y_m] = [0, 1].map(|axis| {
        (region.min.xy_m()[axis] - at_m[axis])
            .max(at_m[axis] - region.max.xy_m()[axis])
            .max(0.0)
    });
    x_m.hypot(y_m)
}
