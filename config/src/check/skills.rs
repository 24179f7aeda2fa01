//! Skills: what they name exists.

use crate::check::reference::Names;
use crate::diagnostic::ProblemKind;
use crate::loaded::SiteConfig;
use crate::report::Report;
use description::site::{ControllerConfig, SkillConfig, StopPlace};

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
