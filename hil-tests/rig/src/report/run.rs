//! The run as map and charts need it: true states with their time, area and place on the lane.

use config::{Area, Manoeuvre, RobotConfig, SiteConfig};
use sim::world::{Pose, Shape, Truth};

use super::Limits;
use crate::one_robot::summary::{RobotSummary, Summary, Violation};

/// One robot's run.
#[derive(Debug)]
pub(super) struct Run<'a> {
    pub(super) site: &'a SiteConfig,
    pub(super) robot: &'a RobotConfig,
    pub(super) summary: &'a Summary,
    pub(super) limits: Limits,
    /// What the site does not know.
    pub(super) obstacles: &'a [Shape],
    /// In order of time.
    pub(super) samples: Vec<Sample>,
}

/// One true state; position, heading and speed are finite.
#[derive(Clone, Copy, Debug)]
pub(super) struct Sample {
    /// Seconds since the start of the run.
    pub(super) at_s: f64,
    /// `base_link` in `map`.
    pub(super) pose: Pose,
    /// Forward speed.
    pub(super) speed_m_s: f64,
    /// Distance of the footprint to anything; infinite where there is nothing.
    pub(super) clearance_m: f64,
    /// Index of the area it is in, or was in last.
    pub(super) area: Option<usize>,
    /// Distance from the lane's centre, positive to the left, in areas that are driven on a lane.
    pub(super) lateral_m: Option<f64>,
    /// It is touching something.
    pub(super) in_contact: bool,
}

impl Sample {
    /// Position of `base_link`.
    pub(super) fn at_m(&self) -> [f64; 2] {
        [self.pose.x_m, self.pose.y_m]
    }

    /// It is too near to something or too far from its lane.
    pub(super) fn is_wrong(&self, limits: &Limits) -> bool {
        let over = |value: Option<f64>, limit: Option<f64>| {
            value
                .zip(limit)
                .is_some_and(|(value, limit)| value.abs() > limit)
        };
        self.in_contact
            || limits
                .clearance_m
                .is_some_and(|least_m| self.clearance_m < least_m)
            || over(self.lateral_m, limits.lateral_m)
    }
}

impl<'a> Run<'a> {
    pub(super) fn new(
        site: &'a SiteConfig,
        robot: &'a RobotConfig,
        path: &[Truth],
        summary: &'a Summary,
        limits: Limits,
        obstacles: &'a [Shape],
    ) -> Self {
        let start_ns = start_ns(path, summary.duration_s);
        let mut area = None;
        let samples = path
            .iter()
            .filter(|truth| truth.pose.is_finite() && truth.twist.v_m_s.is_finite())
            .map(|truth| {
                let at_m = [truth.pose.x_m, truth.pose.y_m];
                // Between areas the last one counts on, as it does for the judge.
                area = site
                    .areas
                    .iter()
                    .position(|area| area.region.contains(at_m))
                    .or(area);
                Sample {
                    at_s: (truth.time_ns as f64 - start_ns as f64) / 1e9,
                    pose: truth.pose,
                    speed_m_s: truth.twist.v_m_s,
                    clearance_m: truth.clearance_m,
                    area,
                    lateral_m: area.and_then(|index| lateral_m(site, &site.areas[index], at_m)),
                    in_contact: truth.in_contact,
                }
            })
            .collect();
        Self {
            site,
            robot,
            summary,
            limits,
            obstacles,
            samples,
        }
    }

    /// The robot's figures, if the summary has them.
    pub(super) fn figures(&self) -> Option<&'a RobotSummary> {
        let id = &self.robot.identity.id;
        self.summary.robots.iter().find(|robot| &robot.id == id)
    }

    /// What it did wrong.
    pub(super) fn violations(&self) -> impl Iterator<Item = &'a Violation> {
        let id = &self.robot.identity.id;
        let of_robot = move |violation: &&Violation| &violation.robot == id;
        self.summary.violations.iter().filter(of_robot)
    }

    /// The state at a time, or the nearest one there is.
    pub(super) fn sample_at(&self, at_s: f64) -> Option<&Sample> {
        let next = self.samples.partition_point(|sample| sample.at_s < at_s);
        self.samples.get(next).or(self.samples.last())
    }

    /// Seconds from the first to the last state, at least 1.
    pub(super) fn time_range_s(&self) -> (f64, f64) {
        let first_s = self.samples.first().map_or(0.0, |first| first.at_s);
        let last_s = self.samples.last().map_or(0.0, |last| last.at_s);
        (first_s.max(0.0), last_s.max(first_s.max(0.0) + 1.0))
    }

    /// Fastest speed that colours and charts must show.
    pub(super) fn top_speed_m_s(&self) -> f64 {
        self.samples
            .iter()
            .map(|sample| sample.speed_m_s.abs())
            .fold(self.robot.drive.max_speed_m_s, f64::max)
            .max(0.01)
    }
}

/// The world's log begins a little before the robot is started, and both end together.
fn start_ns(path: &[Truth], duration_s: f64) -> u64 {
    let (Some(first), Some(last)) = (path.first(), path.last()) else {
        return 0;
    };
    let duration_ns = (duration_s.max(0.0) * 1e9) as u64;
    last.time_ns.saturating_sub(duration_ns).max(first.time_ns)
}

fn lateral_m(site: &SiteConfig, area: &Area, at_m: [f64; 2]) -> Option<f64> {
    if area.control.manoeuvre != Manoeuvre::Forward {
        return None;
    }
    let lane = site.lane(area.lane.as_ref()?)?;
    let [dx, dy] = [0, 1].map(|axis| lane.to_m[axis] - lane.from_m[axis]);
    let [px, py] = [0, 1].map(|axis| at_m[axis] - lane.from_m[axis]);
    let lateral_m = (py * dx - px * dy) / dx.hypot(dy);
    lateral_m.is_finite().then_some(lateral_m)
}
