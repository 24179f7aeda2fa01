//! Translates the site file's terms into those of the skills, which know no files.

use config::SiteConfig;
use coordination::event::EventTable;
use description::site::{
    ControllerConfig, Feature as ConfigFeature, FsmConfig, MonitorKind as ConfigMonitor, StopPlace,
};
use skills::control::TurnDirection;
use skills::map::{AreaData, LaneData, MapData, WallData};
use skills::monitors::MonitorKind;
use skills::perception::{Feature, FeatureSet};
use skills::schedule::{ControllerSetup, MonitorSetup, SkillSetup, StateSetup, StopTarget};

use super::error::PlanError;

/// Walls, lanes and areas.
#[must_use]
pub fn map(site: &SiteConfig) -> MapData {
    MapData {
        walls: site
            .walls
            .iter()
            .map(|wall| WallData {
                id: wall.id.clone(),
                line: wall.line,
            })
            .collect(),
        lanes: site
            .lanes
            .iter()
            .map(|lane| LaneData {
                id: lane.id.clone(),
                line: lane.line,
                end_wall: lane.end_wall.clone(),
            })
            .collect(),
        areas: site
            .areas
            .iter()
            .map(|area| AreaData {
                id: area.id.clone(),
                region: area.region,
                lane: area.lane.clone(),
                speed_limit_m_s: area.control.speed_limit_m_s,
                deviation_limit_m: area.control.deviation_limit_m,
            })
            .collect(),
    }
}

/// What each state of a machine does.
#[must_use]
pub fn states(fsm: &FsmConfig) -> Vec<StateSetup> {
    fsm.states
        .iter()
        .map(|state| StateSetup {
            name: state.name.clone(),
            area: Some(state.area.clone()),
            lane: state.lane.clone(),
            skill: state.skill.clone(),
        })
        .collect()
}

/// Skills as schedules.
#[must_use]
pub fn skills(site: &SiteConfig) -> Vec<SkillSetup> {
    site.skills
        .iter()
        .map(|skill| {
            let kind = site
                .perception_kinds
                .get(&skill.perception)
                .cloned()
                .unwrap_or_default();
            SkillSetup {
                id: skill.id.clone(),
                controller: controller(&skill.controller),
                speed_m_s: skill.speed_m_s,
                tracks: features(&kind.tracks),
                searches: features(&kind.searches),
                monitors: skill.monitors.clone(),
            }
        })
        .collect()
}

/// Monitors with their events.
///
/// # Errors
/// [`PlanError::Events`] when there are more events than a machine can tell apart.
pub fn monitors(
    site: &SiteConfig,
    events: &mut EventTable,
) -> Result<Vec<MonitorSetup>, PlanError> {
    site.monitors
        .iter()
        .map(|monitor| {
            let kind = match &monitor.kind {
                ConfigMonitor::RegionReached { region, .. } => {
                    MonitorKind::RegionReached { region: *region }
                }
                ConfigMonitor::EstimateStable {
                    feature,
                    scans,
                    max_std_m,
                } => MonitorKind::EstimateStable {
                    feature: self::feature(*feature),
                    scans: *scans,
                    max_std_m: *max_std_m,
                },
                ConfigMonitor::ManoeuvreDone => MonitorKind::ManoeuvreDone,
                ConfigMonitor::Deviation { limit_m } => {
                    MonitorKind::Deviation { limit_m: *limit_m }
                }
                ConfigMonitor::After { after_s } => MonitorKind::After { seconds: *after_s },
            };
            let event = events
                .intern(&monitor.event)
                .map_err(|error| PlanError::Events(error.to_string()))?;
            Ok(MonitorSetup {
                id: monitor.event.clone(),
                event,
                kind,
            })
        })
        .collect()
}

fn controller(controller: &ControllerConfig) -> ControllerSetup {
    match *controller {
        ControllerConfig::Corridor { offset_m } => ControllerSetup::Corridor { offset_m },
        ControllerConfig::EndOfLane { distance_m } => ControllerSetup::EndOfLane {
            distance_m,
            exit_speed_m_s: None,
        },
        ControllerConfig::UTurn {
            direction,
            radius_m,
        } => ControllerSetup::UTurn {
            direction: match direction {
                description::site::TurnDirection::Left => TurnDirection::Left,
                description::site::TurnDirection::Right => TurnDirection::Right,
            },
            radius_m,
        },
        ControllerConfig::Stop => ControllerSetup::Stop,
        ControllerConfig::Shift { offset_m, within_m } => {
            ControllerSetup::Shift { offset_m, within_m }
        }
        ControllerConfig::Turn { radius_m } => ControllerSetup::Turn { radius_m },
        ControllerConfig::StopAt { ref place } => ControllerSetup::StopAt {
            target: stop_target(place),
        },
        ControllerConfig::Dock { distance_m } => ControllerSetup::Dock { distance_m },
        ControllerConfig::Creep { distance_m } => ControllerSetup::Creep { distance_m },
    }
}

fn stop_target(place: &StopPlace) -> StopTarget {
    match place {
        StopPlace::BeforeArea { area, margin_m } => StopTarget::BeforeArea {
            area: area.clone(),
            margin_m: *margin_m,
        },
        StopPlace::Pose(at) => StopTarget::Pose(*at),
        StopPlace::Instructed => StopTarget::Instructed,
    }
}

fn features(features: &[ConfigFeature]) -> FeatureSet {
    features.iter().map(|&one| feature(one)).collect()
}

fn feature(feature: ConfigFeature) -> Feature {
    match feature {
        ConfigFeature::Corridor => Feature::Corridor,
        ConfigFeature::LaneEnd => Feature::LaneEnd,
        ConfigFeature::Walls => Feature::Walls,
    }
}
