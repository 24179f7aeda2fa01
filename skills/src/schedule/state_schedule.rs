//! What runs in one state.

use super::controllers::Controller;
use crate::map::SemanticMap;
use crate::monitors::Monitor;
use crate::perception::FeatureSet;
use description::areas::AreaIndex;
use description::geometry::wrap_angle;
use description::site::MonitorKind;

/// What runs in one state.
#[derive(Clone, Debug, PartialEq)]
pub struct Schedule {
    /// Index of the skill.
    pub skill: usize,
    /// The area.
    pub area: Option<AreaIndex>,
    /// Index of the lane that the robot drives on, or onto.
    pub lane: Option<usize>,
    /// Index of the lane that a turn leaves.
    pub from_lane: Option<usize>,
    /// Index of the lane whose end is looked for: that of the state, or the one that a U-turn leaves.
    pub end_lane: Option<usize>,
    /// Features that correct the pose.
    pub tracks: FeatureSet,
    /// Features that run at all.
    pub features: FeatureSet,
    /// What moves the robot.
    pub controller: Controller,
    /// What raises events.
    pub monitors: Vec<Monitor>,
    /// Of the area and the skill.
    pub speed_limit_m_s: f64,
    /// Of the area.
    pub deviation_limit_m: f64,
}

impl Schedule {
    /// The way from the beginning of its controller's manoeuvre to the end, at least.
    #[must_use]
    pub fn least_way_m(&self, map: &SemanticMap) -> f64 {
        let direction_rad = |lane: Option<usize>| Some(map.lanes().get(lane?)?.direction_rad);
        let turn_rad = { direction_rad(self.from_lane).zip(direction_rad(self.lane)) }
            .map(|(from, to)| wrap_angle(to - from));
        self.controller.behaviour().least_way_m(turn_rad)
    }

    /// The least of the area's limit and of those that its monitors watch.
    #[must_use]
    pub fn keep_within_m(&self) -> f64 {
        let limits = self
            .monitors
            .iter()
            .filter_map(|monitor| match monitor.kind {
                MonitorKind::Deviation { limit_m } => limit_m,
                _ => None,
            });
        limits.fold(self.deviation_limit_m, f64::min)
    }
}
