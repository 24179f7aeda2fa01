//! Whether turns begin where the map has room for them, and curves are wide enough for the tubes.

use std::collections::BTreeSet;

use super::findings::Findings;
use super::reach::RobotReach;
use super::role::{Resolved, States};
use description::geometry::Point2;
use description::site::{ControllerConfig, Lane, MonitorKind};

pub(super) fn check(states: &States<'_>, reach: &RobotReach, findings: &mut Findings) {
    for state in states.all() {
        lidar_sees_the_end(state, reach, findings);
        tubes_follow(state, reach, findings);
    }
    for transition in &states.fsm.transitions {
        let (from, to) = (states.named(&transition.from), states.named(&transition.to));
        let Some((from, to)) = from.zip(to) else {
            continue;
        };
        begins_inside(states, &transition.on, from, to, findings);
        has_room(states, from, to, reach, findings);
    }
}

fn lidar_sees_the_end(state: Resolved<'_>, reach: &RobotReach, findings: &mut Findings) {
    let ControllerConfig::EndOfLane { distance_m } = state.skill.controller else {
        return;
    };
    if distance_m > reach.sees_m {
        findings.wrong(
            format!("skills.{}.distance_m", state.skill.id),
            format!("{distance_m:?}"),
            format!("at most {:.3} m, as far as the lidar sees", reach.sees_m),
        );
    }
}

fn tubes_follow(state: Resolved<'_>, reach: &RobotReach, findings: &mut Findings) {
    let (ControllerConfig::UTurn { radius_m, .. } | ControllerConfig::Turn { radius_m }) =
        state.skill.controller
    else {
        return;
    };
    let tightest_m = 1.0 / reach.tube_curvature_1_m;
    if radius_m < tightest_m {
        findings.wrong(
            format!("skills.{}.radius_m", state.skill.id),
            format!("{radius_m:?}"),
            format!("at least {tightest_m:.3} m, for the robot's `tubes.omega_max_rad_s`"),
        );
    }
}

/// The place where "end of lane" is done must be in the next state's area.
fn begins_inside(
    states: &States<'_>,
    event: &str,
    from: Resolved<'_>,
    to: Resolved<'_>,
    findings: &mut Findings,
) {
    let ControllerConfig::EndOfLane { distance_m } = from.skill.controller else {
        return;
    };
    let monitor = states.site.monitor(event);
    if monitor.is_none_or(|monitor| monitor.kind != MonitorKind::ManoeuvreDone) {
        return;
    }
    let Some(done) = { from.lane }.and_then(|lane| before_end_wall(states, lane, distance_m))
    else {
        return;
    };
    if !to.area.region.contains(done) {
        findings.wrong(
            format!("skills.{}.distance_m", from.skill.id),
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

/// The place on the lane's line this far before the wall that closes it.
fn before_end_wall(states: &States<'_>, lane: &Lane, distance_m: f64) -> Option<Point2> {
    let wall = states.site.wall(lane.end_wall.as_deref()?)?;
    let ahead_m = { wall.line }.ray_range_m(lane.line.b, lane.line.direction_rad())?;
    Some(lane.line.b + lane.line.unit() * (ahead_m - distance_m))
}

/// Before a U-turn, the corner that swings out farthest must not reach the wall ahead.
fn has_room(
    states: &States<'_>,
    from: Resolved<'_>,
    turn: Resolved<'_>,
    reach: &RobotReach,
    findings: &mut Findings,
) {
    let ControllerConfig::UTurn { radius_m, .. } = turn.skill.controller else {
        return;
    };
    let f = &reach.footprint;
    let swing_m = (radius_m + f.left_m.max(f.right_m)).hypot(f.front_m);
    let ahead_m = wall_ahead_m(states, f.front_m, &from.state.name, &mut BTreeSet::new());
    let Some(ahead_m) = ahead_m.filter(|ahead_m| *ahead_m <= swing_m) else {
        return;
    };
    let found = format!("which ends {ahead_m:.3} m before the wall");
    let (key, found) = match from.skill.controller {
        ControllerConfig::EndOfLane { distance_m } => ("distance_m", format!("{distance_m:?}")),
        ControllerConfig::Creep { distance_m } => {
            ("distance_m", format!("{distance_m:?}, {found}"))
        }
        _ => {
            let name = from.skill.controller.name();
            ("controller", format!("`{name}`, {found}"))
        }
    };
    findings.wrong(
        format!("skills.{}.{key}", from.skill.id),
        found,
        format!("above {swing_m:.3} m, which the body takes to turn before the wall"),
    );
}

/// How far `base_link` is from the wall ahead when a state is left, where the skills say it.
fn wall_ahead_m<'a>(
    states: &States<'a>,
    front_m: f64,
    state: &'a str,
    seen: &mut BTreeSet<&'a str>,
) -> Option<f64> {
    if !seen.insert(state) {
        return None;
    }
    let before_m = |seen: &mut BTreeSet<&'a str>| {
        { states.fsm.transitions.iter() }
            .filter(|transition| transition.to == state)
            .filter_map(|transition| wall_ahead_m(states, front_m, &transition.from, seen))
            .min_by(f64::total_cmp)
    };
    match states.named(state)?.skill.controller {
        ControllerConfig::EndOfLane { distance_m } => Some(distance_m),
        ControllerConfig::Dock { distance_m } => Some(front_m + distance_m),
        ControllerConfig::Creep { distance_m } => before_m(seen).map(|m| m - distance_m),
        ControllerConfig::Stop => before_m(seen),
        _ => None,
    }
}
