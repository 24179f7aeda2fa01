//! Skills perceive what their controllers and monitors need.

use super::findings::Findings;
use description::site::{
    ControllerConfig, Feature, MonitorKind, PerceptionKind, Site, SkillConfig,
};

pub(super) fn check(site: &Site, findings: &mut Findings) {
    for (id, kind) in &site.perception_kinds {
        let key = format!("perception.kinds.{id}.searches");
        if let Some(both) = { kind.searches.iter() }.find(|feature| kind.tracks.contains(feature)) {
            let found = format!("`{}`, which is tracked already", both.name());
            findings.wrong(
                &key,
                found,
                "features to look for, other than those in `tracks`",
            );
        }
        if kind.searches.contains(&Feature::Walls) {
            findings.wrong(
                &key,
                "`walls`, whose places the map says",
                "`walls` in `tracks`: they correct the pose",
            );
        }
    }
    for monitor in &site.monitors {
        if let MonitorKind::EstimateStable {
            feature: Feature::Walls,
            ..
        } = monitor.kind
        {
            findings.wrong(
                format!("monitors.{}.feature", monitor.event),
                "`walls`, of which there is no estimate",
                "`corridor` or `lane-end`",
            );
        }
    }
    for skill in &site.skills {
        if let Some(kind) = site.perception_kinds.get(&skill.perception) {
            features(skill, kind, findings);
            monitors(site, skill, kind, findings);
        }
    }
}

/// A controller needs its features.
fn features(skill: &SkillConfig, kind: &PerceptionKind, findings: &mut Findings) {
    let needed: &[Feature] = match skill.controller {
        ControllerConfig::Corridor { .. } => &[Feature::Corridor],
        ControllerConfig::EndOfLane { .. } => &[Feature::Corridor, Feature::LaneEnd],
        ControllerConfig::Dock { .. } => &[Feature::LaneEnd],
        // These go by the pose, which any feature corrects.
        ControllerConfig::Shift { .. }
        | ControllerConfig::Turn { .. }
        | ControllerConfig::StopAt { .. }
        | ControllerConfig::Creep { .. }
        | ControllerConfig::UTurn { .. }
        | ControllerConfig::Stop => &[],
    };
    for feature in { needed.iter() }.filter(|feature| !kind.tracks.contains(feature)) {
        findings.wrong(
            format!("skills.{}.perception", skill.id),
            format!(
                "kind `{}`, which does not track `{}`",
                skill.perception,
                feature.name()
            ),
            format!(
                "a kind that does, for the controller `{}`",
                skill.controller.name()
            ),
        );
    }
}

/// A monitor needs something that can make it fire.
fn monitors(site: &Site, skill: &SkillConfig, kind: &PerceptionKind, findings: &mut Findings) {
    for (index, event) in skill.monitors.iter().enumerate() {
        let key = format!("skills.{}.monitors[{index}]", skill.id);
        match site.monitor(event).map(|monitor| &monitor.kind) {
            Some(MonitorKind::EstimateStable { feature, .. })
                if !kind.tracks.contains(feature) && !kind.searches.contains(feature) =>
            {
                findings.wrong(
                    key,
                    format!(
                        "monitor `{event}` of `{}`, which kind `{}` neither tracks nor searches",
                        feature.name(),
                        skill.perception
                    ),
                    "a monitor of something that the skill perceives",
                );
            }
            Some(MonitorKind::ManoeuvreDone) if !skill.controller.ends() => {
                let found = format!(
                    "monitor `{event}` for the end of the controller `{}`, which never ends",
                    skill.controller.name()
                );
                let expected = "it with a controller that ends, any but `corridor` and `stop`";
                findings.wrong(key, found, expected);
            }
            _ => {}
        }
    }
}
