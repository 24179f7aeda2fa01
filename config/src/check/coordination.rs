//! Priorities and coordinations: names. The mediator, which reads the net files, checks whether they fit.

use std::collections::BTreeSet;

use crate::check::reference::Names;
use crate::diagnostic::ProblemKind;
use crate::loaded::SiteConfig;
use crate::report::Report;
use description::site::{CastConfig, CoordinationConfig};

pub(super) fn references(site: &SiteConfig, report: &Report) {
    let roles = Names::new("role", site.fsm.keys());
    for role in site.roles.keys() {
        roles.refer(report, &format!("roles.{role}"), role);
    }
    // Switching the mediator off on the command line, to drive one robot alone, is deliberate and no mistake.
    let managed = "areas.managed";
    let by_override = report.origin.is_written(managed) && report.origin.line(managed).is_none();
    for (id, coordination) in &site.coordinations {
        let key = format!("coordinations.{id}");
        if !site.areas_managed && !by_override {
            report.wrong(
                ProblemKind::Inconsistent,
                &key,
                "a coordination on a site without a mediator",
                "areas.managed = true",
            );
        }
        check(site, &key, coordination, report);
    }
}

fn check(site: &SiteConfig, key: &str, coordination: &CoordinationConfig, report: &Report) {
    for situation in &coordination.situations {
        for (role, cast) in &situation.roles {
            let key = format!("{key}.situations.{}.{role}", situation.situation);
            check_cast(site, &key, cast, report);
        }
    }
    for (role, flags) in &coordination.flags {
        for (flag, meaning) in flags {
            if meaning.event.is_some() == meaning.on_output.is_some() {
                let found = if meaning.event.is_some() {
                    "both `event` and `on_output`"
                } else {
                    "neither `event` nor `on_output`"
                };
                report.wrong(
                    ProblemKind::Inconsistent,
                    &format!("{key}.flags.{role}.{flag}"),
                    found,
                    "`event` for a flag of the mediator, `on_output` for one of the robot",
                );
            }
        }
    }
    let Some(preempt) = &coordination.preempt else {
        return;
    };
    if preempt.after_s < coordination.alarm_after_s {
        report.wrong(
            ProblemKind::Inconsistent,
            &format!("{key}.preempt.after_s"),
            format!("{} s", preempt.after_s),
            format!(
                "at least `alarm_after_s`, {} s: the alarm comes first",
                coordination.alarm_after_s
            ),
        );
    }
    for (role, yields) in &preempt.yields {
        let key = format!("{key}.preempt.yields.{role}");
        if yields.states.is_empty() {
            report.wrong(
                ProblemKind::MissingKey,
                &format!("{key}.states"),
                "nothing",
                "at least one state in which the robot is out of the way",
            );
        }
        states(site, &format!("{key}.states"), &yields.states, report);
        areas(site, &format!("{key}.enters"), &yields.enters, report);
    }
}

fn check_cast(site: &SiteConfig, key: &str, cast: &CastConfig, report: &Report) {
    if let Some(role) = &cast.role {
        Names::new("role", site.fsm.keys()).refer(report, &format!("{key}.role"), role);
    }
    if let Some(robot) = &cast.robot {
        Names::new("robot", site.robots.keys()).refer(report, &format!("{key}.robot"), robot);
    }
    if cast.role.is_none() && cast.robot.is_none() {
        report.wrong(
            ProblemKind::MissingKey,
            key,
            "neither `role` nor `robot`",
            "which robots can play this role",
        );
    }
    for (name, list) in [
        ("holds", &cast.holds),
        ("stands_in", &cast.stands_in),
        ("without", &cast.without),
        ("asks", &cast.asks),
    ] {
        areas(site, &format!("{key}.{name}"), list, report);
    }
    states(site, &format!("{key}.states"), &cast.states, report);
}

fn areas(site: &SiteConfig, key: &str, list: &[String], report: &Report) {
    let areas = Names::new("area", site.areas.iter().map(|area| &area.id));
    areas.refer_all(report, key, list);
}

fn states(site: &SiteConfig, key: &str, list: &[String], report: &Report) {
    let all = { site.fsm.values() }.flat_map(|fsm| fsm.states.iter().map(|state| &state.name));
    let known: BTreeSet<&String> = all.collect();
    Names::new("state", known).refer_all(report, key, list);
}
