//! The state machines: names, determinism, reachability, and whether each state
//! can do in its area what it is for.

use std::collections::{BTreeMap, BTreeSet};

use crate::check::map::{direction, distance_ahead};
use crate::check::reference;
use crate::diagnostic::ProblemKind;
use crate::report::Report;
use crate::site::{
    Area, ControllerConfig, FsmConfig, FsmState, Lane, Manoeuvre, MonitorKind, SiteConfig,
    SkillConfig, TurnDirection,
};

/// A turn may miss its lane by this much, metres.
const TURN_TOLERANCE_M: f64 = 0.05;

pub(super) fn references(site: &SiteConfig, report: &Report) {
    let areas: Vec<&str> = site.areas.iter().map(|area| area.id.as_str()).collect();
    let skills: Vec<&str> = site.skills.iter().map(|skill| skill.id.as_str()).collect();
    for (role, fsm) in &site.fsm {
        let key = format!("fsm.{role}");
        let states: Vec<&str> = fsm.states.iter().map(|state| state.name.as_str()).collect();
        reference(
            report,
            &format!("{key}.initial"),
            &fsm.initial,
            "state",
            &states,
        );
        for state in &fsm.states {
            let key = format!("{key}.states.{}", state.name);
            reference(report, &format!("{key}.area"), &state.area, "area", &areas);
            reference(
                report,
                &format!("{key}.skill"),
                &state.skill,
                "skill",
                &skills,
            );
        }
        let events = events(site, &key, fsm, report);
        for (index, transition) in fsm.transitions.iter().enumerate() {
            let key = format!("{key}.transitions[{index}]");
            reference(
                report,
                &format!("{key}.from"),
                &transition.from,
                "state",
                &states,
            );
            reference(
                report,
                &format!("{key}.to"),
                &transition.to,
                "state",
                &states,
            );
            reference(
                report,
                &format!("{key}.on"),
                &transition.on,
                "event",
                &events,
            );
        }
        duplicates(&key, fsm, report);
        if !report.touched(&[&key]) {
            unreachable_states(&key, fsm, report);
        }
    }
    let roles: Vec<&str> = site.fsm.keys().map(String::as_str).collect();
    for (id, robot) in &site.robots {
        reference(
            report,
            &format!("robots.{id}.role"),
            &robot.role,
            "role",
            &roles,
        );
        if let (Some(name), Some(fsm)) = (&robot.start_state, site.fsm.get(&robot.role)) {
            let states: Vec<&str> = fsm.states.iter().map(|state| state.name.as_str()).collect();
            reference(
                report,
                &format!("robots.{id}.start_state"),
                name,
                "state",
                &states,
            );
        }
    }
}

/// The events that the machine can receive.
fn events<'a>(
    site: &'a SiteConfig,
    key: &str,
    fsm: &'a FsmConfig,
    report: &Report,
) -> Vec<&'a str> {
    let mut events: Vec<&str> = site
        .monitors
        .iter()
        .map(|monitor| monitor.event.as_str())
        .collect();
    for (index, event) in fsm.external.iter().enumerate() {
        if events.contains(&event.as_str()) {
            let found = format!("`{event}`, which is a monitor's or stands here already");
            let expected = "events of other origin, each once";
            let key = format!("{key}.external[{index}]");
            report.wrong(ProblemKind::Duplicate, &key, found, expected);
        }
        events.push(event);
    }
    events
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

/// A state with everything that it names.
#[derive(Clone, Copy)]
struct Resolved<'a> {
    state: &'a FsmState,
    area: &'a Area,
    skill: &'a SkillConfig,
    lane: Option<&'a Lane>,
}

fn resolve<'a>(site: &'a SiteConfig, fsm: &'a FsmConfig, name: &str) -> Option<Resolved<'a>> {
    let state = fsm.state(name)?;
    let area = site.area(&state.area)?;
    let lane = area.lane.as_deref().and_then(|lane| site.lane(lane));
    Some(Resolved {
        state,
        area,
        skill: site.skill(&state.skill)?,
        lane,
    })
}

/// Runs only when every reference is good.
pub(super) fn meaning(site: &SiteConfig, report: &Report) {
    for (role, fsm) in &site.fsm {
        let key = format!("fsm.{role}");
        for state in fsm
            .states
            .iter()
            .filter_map(|state| resolve(site, fsm, &state.name))
        {
            let key = format!("{key}.states.{}", state.state.name);
            manoeuvre(&key, state, report);
            lane_needs(site, &key, state, report);
        }
        for (index, transition) in fsm.transitions.iter().enumerate() {
            let key = format!("{key}.transitions[{index}]");
            let Some(from) = resolve(site, fsm, &transition.from) else {
                continue;
            };
            if !from.skill.monitors.contains(&transition.on)
                && !fsm.external.contains(&transition.on)
            {
                report.wrong(
                    ProblemKind::Inconsistent,
                    &format!("{key}.on"),
                    format!(
                        "`{}`, which skill `{}` does not monitor",
                        transition.on, from.skill.id
                    ),
                    "an event that can occur in the state: of its skill's monitors, or external",
                );
            }
            let Some(to) = resolve(site, fsm, &transition.to) else {
                continue;
            };
            turn_begins_inside(site, &transition.on, from, to, report);
            turn_meets_lane(fsm, site, from, to, report);
        }
    }
}

fn manoeuvre(key: &str, state: Resolved<'_>, report: &Report) {
    let allowed: &[&str] = match state.area.control.manoeuvre {
        Manoeuvre::Forward => &["corridor", "end-of-lane", "stop"],
        Manoeuvre::UTurn => &["u-turn", "stop"],
        Manoeuvre::Stop => &["corridor", "stop"],
    };
    if !allowed.contains(&state.skill.controller.name()) {
        report.wrong(
            ProblemKind::Inconsistent,
            &format!("{key}.skill"),
            format!(
                "skill `{}` with the controller `{}`",
                state.skill.id,
                state.skill.controller.name()
            ),
            format!(
                "a skill for the manoeuvre `{}` of area `{}`",
                state.area.control.manoeuvre.name(),
                state.area.id
            ),
        );
    }
}

/// A skill that follows, ends or watches a lane needs one.
fn lane_needs(site: &SiteConfig, key: &str, state: Resolved<'_>, report: &Report) {
    let ends = matches!(state.skill.controller, ControllerConfig::EndOfLane { .. });
    let follows = ends || matches!(state.skill.controller, ControllerConfig::Corridor);
    let watches = state.skill.monitors.iter().any(|event| {
        site.monitor(event)
            .is_some_and(|m| matches!(m.kind, MonitorKind::Deviation { .. }))
    });
    match state.lane {
        None if follows || watches => report.wrong(
            ProblemKind::Inconsistent,
            &format!("{key}.area"),
            format!("area `{}`, which has no lane", state.area.id),
            format!("an area with a lane, for skill `{}`", state.skill.id),
        ),
        Some(lane) if ends && lane.end_wall.is_none() => report.wrong(
            ProblemKind::Inconsistent,
            &format!("{key}.area"),
            format!(
                "area `{}`, whose lane `{}` has no `end_wall`",
                state.area.id, lane.id
            ),
            format!("an area whose lane has one, for skill `{}`", state.skill.id),
        ),
        _ => {}
    }
}

/// The place where "end of lane" is done must be in the next state's area.
fn turn_begins_inside(
    site: &SiteConfig,
    event: &str,
    from: Resolved<'_>,
    to: Resolved<'_>,
    report: &Report,
) {
    let ControllerConfig::EndOfLane { distance_m } = from.skill.controller else {
        return;
    };
    if !site
        .monitor(event)
        .is_some_and(|m| m.kind == MonitorKind::ManoeuvreDone)
    {
        return;
    }
    let Some(lane) = from.lane else { return };
    let wall = lane.end_wall.as_deref().and_then(|wall| site.wall(wall));
    let Some(ahead_m) = wall.and_then(|wall| distance_ahead(lane, wall)) else {
        return;
    };
    let (dx, dy) = direction(lane);
    let along_m = ahead_m - distance_m;
    let done_m = [lane.to_m[0] + along_m * dx, lane.to_m[1] + along_m * dy];
    let key = format!("skills.{}.distance_m", from.skill.id);
    // One mistake shows in every lane; once is enough.
    if !to.area.region.contains(done_m) && !report.touched(&[&key]) {
        report.wrong(
            ProblemKind::Inconsistent,
            &key,
            format!(
                "{distance_m:?}, so that `{}` ends at ({:.3}, {:.3})",
                from.state.name, done_m[0], done_m[1]
            ),
            format!(
                "an end inside area `{}` of the next state, `{}`",
                to.area.id, to.state.name
            ),
        );
    }
}

/// Half a circle from one lane must end on the next one.
fn turn_meets_lane(
    fsm: &FsmConfig,
    site: &SiteConfig,
    from: Resolved<'_>,
    turn: Resolved<'_>,
    report: &Report,
) {
    let ControllerConfig::UTurn {
        direction: side,
        radius_m,
    } = turn.skill.controller
    else {
        return;
    };
    let Some(before) = from.lane else { return };
    if turn.area.control.manoeuvre != Manoeuvre::UTurn {
        return;
    }
    let key = format!("skills.{}.radius_m", turn.skill.id);
    let (dx, dy) = direction(before);
    for after in fsm
        .transitions
        .iter()
        .filter(|transition| transition.from == turn.state.name)
        .filter_map(|transition| resolve(site, fsm, &transition.to)?.lane)
    {
        let (ex, ey) = (
            after.from_m[0] - before.to_m[0],
            after.from_m[1] - before.to_m[1],
        );
        // To the left of the lane that it comes from.
        let offset_m = dx * ey - dy * ex;
        let turned_m = match side {
            TurnDirection::Left => 2.0 * radius_m,
            TurnDirection::Right => -2.0 * radius_m,
        };
        if (offset_m - turned_m).abs() > TURN_TOLERANCE_M && !report.touched(&[&key]) {
            let hand = if offset_m >= 0.0 { "left" } else { "right" };
            report.wrong(
                ProblemKind::Inconsistent,
                &key,
                format!(
                    "{radius_m:?}, which ends {turned_m:.3} m to the left of lane `{}`",
                    before.id
                ),
                format!(
                    "a turn onto lane `{}`, {:.3} m to the {hand}: radius {:.3}",
                    after.id,
                    offset_m.abs(),
                    offset_m.abs() / 2.0
                ),
            );
        }
    }
}
