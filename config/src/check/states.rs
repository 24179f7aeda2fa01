//! Whether each state can do in its areas and on its lane what it is for.

use crate::check::map::distance_ahead;
use crate::diagnostic::ProblemKind;
use crate::loaded::SiteConfig;
use crate::report::Report;
use description::site::{
    Area, ControllerConfig, FsmConfig, FsmState, Lane, Manoeuvre, MonitorKind, SkillConfig,
    StopPlace, TurnDirection,
};

/// A turn may miss its lane by this much, metres.
const TURN_TOLERANCE_M: f64 = 0.05;

/// A state with everything that it names.
#[derive(Clone, Copy)]
pub(super) struct Resolved<'a> {
    pub(super) state: &'a FsmState,
    pub(super) area: &'a Area,
    pub(super) skill: &'a SkillConfig,
    /// The state's own lane, or the area's.
    pub(super) lane: Option<&'a Lane>,
}

pub(super) fn resolve<'a>(
    site: &'a SiteConfig,
    fsm: &'a FsmConfig,
    name: &str,
) -> Option<Resolved<'a>> {
    let state = fsm.state(name)?;
    let area = site.area(&state.area)?;
    let lane = state.lane.as_deref().or(area.lane.as_deref());
    let lane = lane.and_then(|lane| site.lane(lane));
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
            lane_is_near(site, &key, state, report);
            instructed(fsm, state, report);
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
    let along: &[&str] = &["corridor", "shift", "stop-at", "creep", "stop"];
    let allowed: &[&[&str]] = match state.area.control.manoeuvre {
        Manoeuvre::Forward => &[along, &["end-of-lane"]],
        Manoeuvre::UTurn => &[&["u-turn", "creep", "stop"]],
        Manoeuvre::Stop => &[along],
        Manoeuvre::Turn => &[&["turn", "creep", "stop"]],
        Manoeuvre::Dock => &[along, &["dock"]],
        Manoeuvre::Any => return,
    };
    if !allowed.concat().contains(&state.skill.controller.name()) {
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
    let controller = &state.skill.controller;
    let ends = matches!(
        controller,
        ControllerConfig::EndOfLane { .. } | ControllerConfig::Dock { .. }
    );
    let needs = controller.follows_lane() || matches!(controller, ControllerConfig::Turn { .. });
    let watches = state.skill.monitors.iter().any(|event| {
        site.monitor(event)
            .is_some_and(|m| matches!(m.kind, MonitorKind::Deviation { .. }))
    });
    match state.lane {
        None if needs || watches => {
            let problem = report.problem(
                ProblemKind::Inconsistent,
                &format!("{key}.area"),
                format!("area `{}`, which has no lane", state.area.id),
                format!("an area with a lane, for skill `{}`", state.skill.id),
            );
            report.push(problem.with_hint("or give the state a `lane` of its own"));
        }
        Some(lane) if ends && lane.end_wall.is_none() => {
            let own = state.state.lane.is_some();
            let (name, found) = if own {
                ("lane", format!("lane `{}` without `end_wall`", lane.id))
            } else {
                let found = format!(
                    "area `{}`, whose lane `{}` has no `end_wall`",
                    state.area.id, lane.id
                );
                ("area", found)
            };
            report.wrong(
                ProblemKind::Inconsistent,
                &format!("{key}.{name}"),
                found,
                format!("a lane that has one, for skill `{}`", state.skill.id),
            );
        }
        _ => {}
    }
}

/// A state's own lane must touch the floor that the state takes.
fn lane_is_near(site: &SiteConfig, key: &str, state: Resolved<'_>, report: &Report) {
    let (Some(lane), Some(_)) = (state.lane, &state.state.lane) else {
        return;
    };
    let mut areas = state.state.areas().filter_map(|area| site.area(area));
    if !areas.any(|area| area.region.clip(&lane.line).is_some()) {
        report.wrong(
            ProblemKind::Inconsistent,
            &format!("{key}.lane"),
            format!(
                "lane `{}`, which does not touch area `{}`",
                lane.id, state.area.id
            ),
            "a lane in the state's areas, or one that begins or ends at their border",
        );
    }
}

/// A pose that comes with an event needs an event that can bring one.
fn instructed(fsm: &FsmConfig, state: Resolved<'_>, report: &Report) {
    let ControllerConfig::StopAt {
        place: StopPlace::Instructed,
    } = &state.skill.controller
    else {
        return;
    };
    let key = format!("skills.{}.controller", state.skill.id);
    let mut transitions = fsm.transitions.iter();
    let brings = transitions.any(|t| t.to == state.state.name && fsm.external.contains(&t.on));
    if !brings && !report.touched(&[&key]) {
        report.wrong(
            ProblemKind::Inconsistent,
            &key,
            format!(
                "`stop-at` without a place, in state `{}`, which no external event leads to",
                state.state.name
            ),
            "`before_area` or `pose`, or an external event that brings a pose",
        );
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
    let done = lane.line.b + lane.line.unit() * (ahead_m - distance_m);
    let key = format!("skills.{}.distance_m", from.skill.id);
    // One mistake shows in every lane; once is enough.
    if !to.area.region.contains(done) && !report.touched(&[&key]) {
        report.wrong(
            ProblemKind::Inconsistent,
            &key,
            format!(
                "{distance_m:?}, so that `{}` ends at ({:.3}, {:.3})",
                from.state.name, done.x_m, done.y_m
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
    let key = format!("skills.{}.radius_m", turn.skill.id);
    for after in fsm
        .transitions
        .iter()
        .filter(|transition| transition.from == turn.state.name)
        .filter_map(|transition| resolve(site, fsm, &transition.to)?.lane)
        // A state that waits during the turn already names the lane that the turn ends on.
        .filter(|after| after.id != before.id)
    {
        // To the left of the lane that it comes from.
        let offset_m = before.line.lateral_m(after.line.a);
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
