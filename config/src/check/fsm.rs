//! The state machines: names, determinism, reachability.

use std::collections::{BTreeMap, BTreeSet};

use crate::check::reference::Names;
use crate::diagnostic::ProblemKind;
use crate::loaded::SiteConfig;
use crate::report::Report;
use description::site::{FsmConfig, FsmState, FsmTransition};

pub(super) fn references(site: &SiteConfig, report: &Report) {
    let areas = Names::new("area", site.areas.iter().map(|area| &area.id));
    let lanes = Names::new("lane", site.lanes.iter().map(|lane| &lane.id));
    let skills = Names::new("skill", site.skills.iter().map(|skill| &skill.id));
    for (role, fsm) in &site.fsm {
        let key = format!("fsm.{role}");
        let states = states(fsm);
        states.refer(report, &format!("{key}.initial"), &fsm.initial);
        for state in &fsm.states {
            let key = format!("{key}.states.{}", state.name);
            areas.refer(report, &format!("{key}.area"), &state.area);
            further_areas(&key, state, &areas, report);
            if let Some(lane) = &state.lane {
                lanes.refer(report, &format!("{key}.lane"), lane);
            }
            skills.refer(report, &format!("{key}.skill"), &state.skill);
        }
        let events = events(site, &key, fsm, report);
        for (index, transition) in fsm.transitions.iter().enumerate() {
            let key = format!("{key}.transitions[{index}]");
            states.refer(report, &format!("{key}.from"), &transition.from);
            states.refer(report, &format!("{key}.to"), &transition.to);
            events.refer(report, &format!("{key}.on"), &transition.on);
            occurs_there(site, fsm, &key, transition, report);
        }
        duplicates(&key, fsm, report);
        if !report.touched(&[&key]) {
            unreachable_states(&key, fsm, report);
        }
    }
    let roles = Names::new("role", site.fsm.keys());
    for (id, robot) in &site.robots {
        let key = format!("robots.{id}");
        roles.refer(report, &format!("{key}.role"), &robot.role);
        if let (Some(name), Some(fsm)) = (&robot.start_state, site.fsm.get(&robot.role)) {
            states(fsm).refer(report, &format!("{key}.start_state"), name);
        }
    }
}

fn states(fsm: &FsmConfig) -> Names<'_> {
    Names::new("state", fsm.states.iter().map(|state| &state.name))
}

/// The events that the machine can receive.
fn events<'a>(site: &'a SiteConfig, key: &str, fsm: &'a FsmConfig, report: &Report) -> Names<'a> {
    let mut events: Vec<&String> = { site.monitors.iter() }
        .map(|monitor| &monitor.event)
        .collect();
    for (index, event) in fsm.external.iter().enumerate() {
        if events.contains(&event) {
            let found = format!("`{event}`, which is a monitor's or stands here already");
            let expected = "events of other origin, each once";
            let key = format!("{key}.external[{index}]");
            report.wrong(ProblemKind::Duplicate, &key, found, expected);
        }
        events.push(event);
    }
    Names::new("event", events)
}

/// What a state's skill does not monitor cannot occur there, unless it comes from outside.
fn occurs_there(
    site: &SiteConfig,
    fsm: &FsmConfig,
    key: &str,
    transition: &FsmTransition,
    report: &Report,
) {
    let (key, on) = (format!("{key}.on"), &transition.on);
    let skill = fsm.state(&transition.from);
    let Some(skill) = skill.and_then(|state| site.skill(&state.skill)) else {
        return;
    };
    let occurs = skill.monitors.contains(on) || fsm.external.contains(on);
    if occurs || report.touched(&["monitors", "skills", &key]) {
        return;
    }
    let found = format!("`{on}`, which skill `{}` does not monitor", skill.id);
    let expected = "an event that can occur in the state: of its skill's monitors, or external";
    report.wrong(ProblemKind::Inconsistent, &key, found, expected);
}

fn duplicates(key: &str, fsm: &FsmConfig, report: &Report) {
    let mut seen: BTreeMap<(&str, &str), usize> = BTreeMap::new();
    for (index, transition) in fsm.transitions.iter().enumerate() {
        if transition.from.is_empty() || transition.on.is_empty() {
            continue;
        }
        let Some(first) = seen.insert((&transition.from, &transition.on), index) else {
            continue;
        };
        let problem = report.problem(
            ProblemKind::Duplicate,
            &format!("{key}.transitions[{index}]"),
            format!(
                "a second transition from `{}` on `{}`",
                transition.from, transition.on
            ),
            "at most one for a state and an event",
        );
        let first = format!("{key}.transitions[{first}]");
        report.push(report.origin.also(problem, &first, "the first one"));
    }
}

fn unreachable_states(key: &str, fsm: &FsmConfig, report: &Report) {
    let mut reached = BTreeSet::from([fsm.initial.as_str()]);
    let mut waiting = vec![fsm.initial.as_str()];
    while let Some(state) = waiting.pop() {
        for transition in fsm
            .transitions
            .iter()
            .filter(|transition| transition.from == state)
        {
            if reached.insert(&transition.to) {
                waiting.push(&transition.to);
            }
        }
    }
    for state in fsm
        .states
        .iter()
        .filter(|state| !reached.contains(state.name.as_str()))
    {
        report.wrong(
            ProblemKind::Inconsistent,
            &format!("{key}.states.{}", state.name),
            format!("state `{}`, which no transitions lead to", state.name),
            format!("states that can be reached from `{}`", fsm.initial),
        );
    }
}

fn further_areas(key: &str, state: &FsmState, areas: &Names, report: &Report) {
    for (index, area) in state.also.iter().enumerate() {
        let key = format!("{key}.also[{index}]");
        areas.refer(report, &key, area);
        if !area.is_empty() && (*area == state.area || state.also[..index].contains(area)) {
            let found = format!("area `{area}` a second time");
            report.wrong(ProblemKind::Duplicate, &key, found, "each area once");
        }
    }
}
