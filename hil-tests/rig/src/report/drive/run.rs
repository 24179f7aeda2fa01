//! The run as map and charts need it: true states with their time, area and place on the lane.

use config::SiteConfig;
use sim::world::{Pose, Shape};

use crate::lanes::forward_lane;
use crate::record::{Record, RobotRecord};
use crate::scenario::Limits;
use crate::summary::{RobotSummary, Summary, Violation};

/// One robot's run.
#[derive(Debug)]
pub(super) struct DrawnRun<'a> {
    pub(super) site: &'a SiteConfig,
    pub(super) robot: &'a RobotRecord,
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

    /// It is nearer to something or farther from its lane than the limits allow.
    pub(super) fn is_wrong(&self, limits: &Limits) -> bool {
        let off_lane = self.lateral_m.zip(limits.lateral_error_m);
        self.in_contact
            || self.clearance_m < limits.clearance_m
            || off_lane.is_some_and(|(lateral_m, most_m)| lateral_m.abs() > most_m)
    }
}

impl<'a> DrawnRun<'a> {
    pub(super) fn new(record: &'a Record, robot: &'a RobotRecord) -> Self {
        let site = &record.site;
        let mut area = None;
        let samples = { robot.path.iter() }
            .filter(|point| point.pose.is_finite() && point.speed_m_s.is_finite())
            .map(|point| {
                let at_m = [point.pose.x_m, point.pose.y_m];
                // Between areas the last one counts on, as it does for the judge.
                area = { site.areas.iter() }
                    .position(|area| area.region.contains(at_m.into()))
                    .or(area);
                Sample {
                    at_s: point.at_s,
                    pose: point.pose,
                    speed_m_s: point.speed_m_s,
                    clearance_m: point.clearance_m,
                    area,
                    lateral_m: { area.and_then(|index| forward_lane(site, &site.areas[index])) }
                        .map(|lane| lane.line.lateral_m(at_m.into()))
                        .filter(|lateral_m| lateral_m.is_finite()),
                    in_contact: point.in_contact,
                }
            })
            .collect();
        Self {
            site,
            robot,
            summary: &record.summary,
            limits: record.limits,
            obstacles: &record.obstacles,
            samples,
        }
    }

    /// The robot's figures, if the summary has them.
    pub(super) fn figures(&self) -> Option<&'a RobotSummary> {
        let id = &self.robot.id;
        self.summary.robots.iter().find(|robot| &robot.id == id)
    }

    /// What it did wrong.
    pub(super) fn violations(&self) -> impl Iterator<Item = &'a Violation> {
        let id = &self.robot.id;
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
            .fold(self.robot.max_speed_m_s, f64::max)
            .max(0.01)
    }
}
