//! Whether the robot's body fits its start, its lanes and its areas.

use std::collections::BTreeSet;

use super::findings::Findings;
use super::role::{Resolved, States};
use description::geometry::{Footprint, Point2, Pose2, Segment};
use description::keys::{quoted_list, rounded};
use description::site::{ControllerConfig, Lane, Site};

/// Way between the places that are looked at, metres.
const STEP_M: f64 = 0.1;
const MOST_STEPS: f64 = 1000.0;

pub(super) fn check(states: &States<'_>, footprint: &Footprint, findings: &mut Findings) {
    let mut told = BTreeSet::new();
    for state in states.all() {
        let Some(lane) = state.lane else { continue };
        lane_is_wide_enough(states.site, footprint, lane, findings);
        // The same piece of lane is too narrow for every state on it; once is enough.
        let place = (lane.id.as_str(), state.area.id.as_str());
        if state.skill.controller.follows_lane()
            && !told.contains(&place)
            && let Some((side, at)) = leaves_its_areas(states, footprint, state, lane)
        {
            told.insert(place);
            let areas: Vec<&str> = state.state.areas().collect();
            findings.wrong(
                states.key(state.state),
                format!(
                    "a body whose {side} side leaves {} on lane `{}`, at ({}, {})",
                    quoted_list(&areas, "and"),
                    lane.id,
                    rounded(at.x_m),
                    rounded(at.y_m)
                ),
                format!(
                    "areas as wide as the robot, {} m, along the lane: widen the area, move the lane, or name the neighbour in the state's `also`",
                    rounded(footprint.left_m + footprint.right_m)
                ),
            );
        }
    }
}

pub(super) fn start_is_free(
    site: &Site,
    footprint: &Footprint,
    robot: &str,
    start: Pose2,
    findings: &mut Findings,
) {
    let corners = footprint.corners().map(|corner| start.transform(corner));
    for wall in &site.walls {
        let crosses = (0..4)
            .any(|index| Segment::new(corners[index], corners[(index + 1) % 4]).meets(&wall.line));
        if crosses || footprint.contains(start.inverse_transform(wall.line.a)) {
            findings.wrong(
                format!("robots.{robot}.start"),
                format!("a start with the body in wall `{}`", wall.id),
                "a start with the whole footprint free",
            );
        }
    }
}

/// The body must pass between the walls beside the lane.
fn lane_is_wide_enough(site: &Site, footprint: &Footprint, lane: &Lane, findings: &mut Findings) {
    let half_width_m = footprint.left_m.max(footprint.right_m);
    for wall in &site.walls {
        let (a, b) = (&lane.line, &wall.line);
        let distance_m = a.distance_m(b.a).min(a.distance_m(b.b));
        let distance_m = distance_m.min(b.distance_m(a.a)).min(b.distance_m(a.b));
        if distance_m <= half_width_m {
            findings.wrong(
                format!("lanes.{}", lane.id),
                format!("a lane {distance_m:.3} m from wall `{}`", wall.id),
                format!("more than {half_width_m} m, half of the robot's width"),
            );
        }
    }
}

/// Along its lane, both sides of the body must stay on the floor of the state's areas; else which side leaves it, and where.
fn leaves_its_areas(
    states: &States<'_>,
    footprint: &Footprint,
    state: Resolved<'_>,
    lane: &Lane,
) -> Option<(&'static str, Point2)> {
    let (enter, leave) = state.area.region.clip(&lane.line)?;
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
    let sides = [("left", footprint.left_m), ("right", -footprint.right_m)];
    let places = (0..=steps as usize).flat_map(|step| {
        let along_m = (enter + (leave - enter) * step as f64 / steps) * length_m;
        let on_lane = lane.line.a + unit * along_m;
        sides.map(|(side, aside_m)| (side, on_lane + left * (aside_m + offset_m)))
    });
    let mut places = places;
    places.find(|(_, point)| {
        let mut areas = { state.state.areas() }.filter_map(|area| states.site.area(area));
        !areas.any(|area| area.region.contains(*point))
    })
}
