//! Whether the robot's width fits the lanes and areas of its state machine.

use std::collections::BTreeSet;

use crate::check::states::{Resolved, resolve};
use crate::diagnostic::{Problem, ProblemKind};
use crate::loaded::RobotConfig;
use crate::loaded::SiteConfig;
use description::geometry::Point2;
use description::keys::{quoted_list, rounded};
use description::site::{ControllerConfig, FsmConfig, Lane};

/// Way between the places that are looked at, metres.
const STEP_M: f64 = 0.1;
const MOST_STEPS: f64 = 1000.0;

pub(super) fn check(
    robot: &RobotConfig,
    site: &SiteConfig,
    role: &str,
    fsm: &FsmConfig,
    problems: &mut Vec<Problem>,
) {
    let (mut lanes, mut places) = (BTreeSet::new(), BTreeSet::new());
    for state in &fsm.states {
        let Some(state) = resolve(site, fsm, &state.name) else {
            continue;
        };
        let Some(lane) = state.lane else { continue };
        if lanes.insert(lane.id.as_str()) {
            lane_is_wide_enough(robot, site, lane, problems);
        }
        // One mistake shows in every state there; once is enough.
        let place = (lane.id.as_str(), state.area.id.as_str());
        if state.skill.controller.follows_lane() && !places.contains(&place) {
            let before = problems.len();
            areas_hold_the_width(robot, site, role, state, lane, problems);
            if problems.len() > before {
                places.insert(place);
            }
        }
    }
}

/// Before each U-turn, the corner that swings out farthest must not reach the wall ahead.
pub(super) fn to_turn(
    robot: &RobotConfig,
    site: &SiteConfig,
    fsm: &FsmConfig,
    problems: &mut Vec<Problem>,
) {
    let f = &robot.footprint;
    let mut told = BTreeSet::new();
    for transition in &fsm.transitions {
        let (Some(from), Some(turn)) = (
            resolve(site, fsm, &transition.from),
            resolve(site, fsm, &transition.to),
        ) else {
            continue;
        };
        let ControllerConfig::UTurn { radius_m, .. } = turn.skill.controller else {
            continue;
        };
        let reach_m = (radius_m + f.left_m.max(f.right_m)).hypot(f.front_m);
        let ahead_m = wall_ahead_m(robot, site, fsm, &transition.from, &mut BTreeSet::new());
        let Some(ahead_m) = ahead_m.filter(|ahead_m| *ahead_m <= reach_m) else {
            continue;
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
        if told.insert(from.skill.id.as_str()) {
            problems.push(site.origin.problem(
                ProblemKind::Inconsistent,
                &format!("skills.{}.{key}", from.skill.id),
                found,
                format!("above {reach_m:.3} m, which the body takes to turn before the wall"),
            ));
        }
    }
}

/// How far `base_link` is from the wall ahead when a state is left, where the skills say it.
fn wall_ahead_m<'a>(
    robot: &RobotConfig,
    site: &SiteConfig,
    fsm: &'a FsmConfig,
    state: &'a str,
    seen: &mut BTreeSet<&'a str>,
) -> Option<f64> {
    if !seen.insert(state) {
        return None;
    }
    let before_m = |seen: &mut BTreeSet<&'a str>| {
        fsm.transitions
            .iter()
            .filter(|transition| transition.to == state)
            .filter_map(|transition| wall_ahead_m(robot, site, fsm, &transition.from, seen))
            .min_by(f64::total_cmp)
    };
    match resolve(site, fsm, state)?.skill.controller {
        ControllerConfig::EndOfLane { distance_m } => Some(distance_m),
        ControllerConfig::Dock { distance_m } => Some(robot.footprint.front_m + distance_m),
        ControllerConfig::Creep { distance_m } => before_m(seen).map(|m| m - distance_m),
        ControllerConfig::Stop => before_m(seen),
        _ => None,
    }
}

/// The body must pass between the walls beside the lane.
fn lane_is_wide_enough(
    robot: &RobotConfig,
    site: &SiteConfig,
    lane: &Lane,
    problems: &mut Vec<Problem>,
) {
    let half_width_m = robot.footprint.left_m.max(robot.footprint.right_m);
    for wall in &site.walls {
        let (a, b) = (&lane.line, &wall.line);
        let distance_m = a.distance_m(b.a).min(a.distance_m(b.b));
        let distance_m = distance_m.min(b.distance_m(a.a)).min(b.distance_m(a.b));
        if distance_m <= half_width_m {
            problems.push(site.origin.problem(
                ProblemKind::Inconsistent,
                &format!("lanes.{}", lane.id),
                format!("a lane {distance_m:.3} m from wall `{}`", wall.id),
                format!("more than {half_width_m} m, half of the robot's width"),
            ));
        }
    }
}

/// Along its lane, both sides of the body must stay on the floor of the state's areas.
fn areas_hold_the_width(
    robot: &RobotConfig,
    site: &SiteConfig,
    role: &str,
    state: Resolved<'_>,
    lane: &Lane,
    problems: &mut Vec<Problem>,
) {
    let Some((enter, leave)) = state.area.region.clip(&lane.line) else {
        return;
    };
    let offset_m = match state.skill.controller {
        ControllerConfig::Corridor { offset_m } | ControllerConfig::Shift { offset_m, .. } => {
            offset_m
        }
        _ => 0.0,
    };
    let (unit, length_m) = (lane.line.unit(), lane.line.length_m());
    let left = Point2::new(-unit.y_m, unit.x_m);
    let steps = ((leave - enter) * length_m / STEP_M)
        .ceil()
        .clamp(1.0, MOST_STEPS);
    let sides = [
        ("left", robot.footprint.left_m),
        ("right", -robot.footprint.right_m),
    ];
    for step in 0..=steps as usize {
        let along_m = (enter + (leave - enter) * step as f64 / steps) * length_m;
        for (side, aside_m) in sides {
            let point = lane.line.a + unit * along_m + left * (aside_m + offset_m);
            let held = state.state.areas().any(|area| {
                site.area(area)
                    .is_some_and(|area| area.region.contains(point))
            });
            if held {
                continue;
            }
            let areas: Vec<&str> = state.state.areas().collect();
            let problem = site.origin.problem(
                ProblemKind::Inconsistent,
                &format!("fsm.{role}.states.{}", state.state.name),
                format!(
                    "a body whose {side} side leaves {} on lane `{}`, at ({}, {})",
                    quoted_list(&areas, "and"),
                    lane.id,
                    rounded(point.x_m),
                    rounded(point.y_m)
                ),
                format!(
                    "areas as wide as the robot, {} m, along the lane",
                    rounded(robot.footprint.left_m + robot.footprint.right_m)
                ),
            );
            problems.push(problem.with_hint(
                "widen the area, move the lane, or name the neighbour in the state's `also`",
            ));
            return;
        }
    }
}
