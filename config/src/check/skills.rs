//! Skills: what they name exists, and their parts can work together.

use crate::check::reference::Names;
use crate::diagnostic::ProblemKind;
use crate::loaded::SiteConfig;
use crate::report::Report;
use description::site::{
    ControllerConfig, Feature, MonitorKind, PerceptionKind, SkillConfig, StopPlace,
};

pub(super) fn references(site: &SiteConfig, report: &Report) {
    let kinds = Names::new("perception kind", site.perception_kinds.keys());
    let events = Names::new(
        "monitor",
        site.monitors.iter().map(|monitor| &monitor.event),
    );
    let areas = Names::new("area", site.areas.iter().map(|area| &area.id));
    for skill in &site.skills {
        let key = format!("skills.{}", skill.id);
        if let ControllerConfig::StopAt {
            place: StopPlace::BeforeArea { area, .. },
        } = &skill.controller
        {
            areas.refer(report, &format!("{key}.before_area"), area);
        }
        speed(skill, &format!("{key}.speed_m_s"), report);
        kinds.refer(report, &format!("{key}.perception"), &skill.perception);
        events.refer_all(report, &format!("{key}.monitors"), &skill.monitors);
        for (index, event) in skill.monitors.iter().enumerate() {
            let key = format!("{key}.monitors[{index}]");
            if !event.is_empty() && skill.monitors[..index].contains(event) {
                let found = format!("`{event}` a second time");
                report.wrong(ProblemKind::Duplicate, &key, found, "each monitor once");
            }
        }
    }
}

/// `stop` takes no speed. `creep` needs one: a person must choose how fast to approach a wall.
fn speed(skill: &SkillConfig, key: &str, report: &Report) {
    if report.touched(&[&format!("skills.{}.controller", skill.id)]) {
        return;
    }
    match skill.controller {
        ControllerConfig::Stop if skill.speed_m_s.is_some() => report.wrong(
            ProblemKind::UnknownKey,
            key,
            "unknown key `speed_m_s`",
            format!("no speed in [skills.{}]: the robot stands still", skill.id),
        ),
        ControllerConfig::Creep { .. } if skill.speed_m_s.is_none() => report.wrong(
            ProblemKind::MissingKey,
            key,
            "nothing",
            "a speed above 0 and at most 3 m/s, as the controller is `creep`".to_owned(),
        ),
        _ => {}
    }
}

pub(super) fn meaning(site: &SiteConfig, report: &Report) {
    for (id, kind) in &site.perception_kinds {
        if let Some(both) = kind
            .searches
            .iter()
            .find(|feature| kind.tracks.contains(feature))
        {
            report.wrong(
                ProblemKind::Inconsistent,
                &format!("perception.kinds.{id}.searches"),
                format!("`{}`, which is tracked already", both.name()),
                "features to look for, other than those in `tracks`",
            );
        }
        if kind.searches.contains(&Feature::Walls) {
            report.wrong(
                ProblemKind::Inconsistent,
                &format!("perception.kinds.{id}.searches"),
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
            report.wrong(
                ProblemKind::Inconsistent,
                &format!("monitors.{}.feature", monitor.event),
                "`walls`, of which there is no estimate",
                "`corridor` or `lane-end`",
            );
        }
    }
    for skill in &site.skills {
        if let Some(kind) = site.perception_kinds.get(&skill.perception) {
            perception(skill, kind, report);
            monitors(site, skill, kind, report);
        }
    }
}

/// A controller needs its features.
fn perception(skill: &SkillConfig, kind: &PerceptionKind, report: &Report) {
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
    for feature in needed
        .iter()
        .filter(|feature| !kind.tracks.contains(feature))
    {
        report.wrong(
            ProblemKind::Inconsistent,
            &format!("skills.{}.perception", skill.id),
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
fn monitors(site: &SiteConfig, skill: &SkillConfig, kind: &PerceptionKind, report: &Report) {
    for (index, event) in skill.monitors.iter().enumerate() {
        let key = format!("skills.{}.monitors[{index}]", skill.id);
        match site.monitor(event).map(|monitor| &monitor.kind) {
            Some(MonitorKind::EstimateStable { feature, .. })
                if !kind.tracks.contains(feature) && !kind.searches.contains(feature) =>
            {
                report.wrong(
                    ProblemKind::Inconsistent,
                    &key,
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
                report.wrong(ProblemKind::Inconsistent, &key, found, expected);
            }
            _ => {}
        }
    }
}
