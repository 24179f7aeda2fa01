//! Whether each state can do in its areas and on its lane what it is for.

use super::findings::Findings;
use super::role::{Resolved, States};
use description::site::{ControllerConfig, Manoeuvre, MonitorKind, StopPlace};

pub(super) fn check(states: &States<'_>, findings: &mut Findings) {
    for state in states.all() {
        manoeuvre(states, state, findings);
        watched_lane(states, state, findings);
        lane_is_near(states, state, findings);
        instructed(states, state, findings);
    }
}

/// The area says what is done in it.
fn manoeuvre(states: &States<'_>, state: Resolved<'_>, findings: &mut Findings) {
    let along: &[&str] = &["corridor", "shift", "stop-at", "creep", "stop"];
    let allowed: &[&[&str]] = match state.area.control.manoeuvre {
        Manoeuvre::Forward => &[along, &["end-of-lane"]],
        Manoeuvre::UTurn => &[&["u-turn", "creep", "stop"]],
        Manoeuvre::Stop => &[along],
        Manoeuvre::Turn => &[&["turn", "creep", "stop"]],
        Manoeuvre::Dock => &[along, &["dock"]],
        Manoeuvre::Any => return,
    };
    let name = state.skill.controller.name();
    if !allowed.concat().contains(&name) {
        findings.wrong(
            format!("{}.skill", states.key(state.state)),
            format!("skill `{}` with the controller `{name}`", state.skill.id),
            format!(
                "a skill for the manoeuvre `{}` of area `{}`",
                state.area.control.manoeuvre.name(),
                state.area.id
            ),
        );
    }
}

/// Deviation is measured from a lane.
fn watched_lane(states: &States<'_>, state: Resolved<'_>, findings: &mut Findings) {
    let is_deviation = |event: &String| {
        let monitor = states.site.monitor(event);
        monitor.is_some_and(|m| matches!(m.kind, MonitorKind::Deviation { .. }))
    };
    if state.lane.is_none() && state.skill.monitors.iter().any(is_deviation) {
        findings.wrong(
            format!("{}.area", states.key(state.state)),
            format!("area `{}`, which has no lane", state.area.id),
            format!(
                "an area with a lane, or a `lane` of the state's own: skill `{}` watches the deviation from it",
                state.skill.id
            ),
        );
    }
}

/// A state's own lane must touch the floor that the state takes.
fn lane_is_near(states: &States<'_>, state: Resolved<'_>, findings: &mut Findings) {
    let (Some(lane), Some(_)) = (state.lane, &state.state.lane) else {
        return;
    };
    let mut areas = { state.state.areas() }.filter_map(|area| states.site.area(area));
    if !areas.any(|area| area.region.clip(&lane.line).is_some()) {
        findings.wrong(
            format!("{}.lane", states.key(state.state)),
            format!(
                "lane `{}`, which does not touch area `{}`",
                lane.id, state.area.id
            ),
            "a lane in the state's areas, or one that begins or ends at their border",
        );
    }
}

/// A pose that comes with an event needs an event that can bring one.
fn instructed(states: &States<'_>, state: Resolved<'_>, findings: &mut Findings) {
    let ControllerConfig::StopAt {
        place: StopPlace::Instructed,
    } = &state.skill.controller
    else {
        return;
    };
    let fsm = states.fsm;
    let mut transitions = fsm.transitions.iter();
    let brings = transitions.any(|t| t.to == state.state.name && fsm.external.contains(&t.on));
    if !brings {
        findings.wrong(
            format!("skills.{}.controller", state.skill.id),
            format!(
                "`stop-at` without a place, in state `{}`, which no external event leads to",
                state.state.name
            ),
            "`before_area` or `pose`, or an external event that brings a pose",
        );
    }
}
