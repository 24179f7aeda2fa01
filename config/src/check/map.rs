//! The semantic map: references, and whether its geometry makes sense.

use std::collections::BTreeMap;
use std::f64::consts::FRAC_PI_4;

use crate::check::reference::Names;
use crate::diagnostic::ProblemKind;
use crate::loaded::SiteConfig;
use crate::report::Report;
use description::geometry::{Segment, wrap_angle};
use description::site::{Lane, MonitorKind, RegionRef, Wall};

/// Shorter walls and lanes are typing mistakes.
const SHORTEST_M: f64 = 0.01;

pub(super) fn references(site: &SiteConfig, report: &Report) {
    let walls = Names::new("wall", site.walls.iter().map(|wall| &wall.id));
    let lanes = Names::new("lane", site.lanes.iter().map(|lane| &lane.id));
    let areas = Names::new("area", site.areas.iter().map(|area| &area.id));
    let zones = Names::new("zone", site.perception.iter().map(|zone| &zone.id));
    let kinds = Names::new("perception kind", site.perception_kinds.keys());
    for lane in &site.lanes {
        if let Some(wall) = &lane.end_wall {
            walls.refer(report, &format!("lanes.{}.end_wall", lane.id), wall);
        }
    }
    for area in &site.areas {
        if let Some(lane) = &area.lane {
            lanes.refer(report, &format!("areas.{}.lane", area.id), lane);
        }
    }
    for zone in &site.perception {
        let key = format!("perception.zones.{}.kind", zone.id);
        kinds.refer(report, &key, &zone.kind);
    }
    for monitor in &site.monitors {
        let key = |name: &str| format!("monitors.{}.{name}", monitor.event);
        if let MonitorKind::RegionReached { of, .. } = &monitor.kind {
            match of {
                RegionRef::Area(id) => areas.refer(report, &key("area"), id),
                RegionRef::Zone(id) => zones.refer(report, &key("zone"), id),
                RegionRef::Own => {}
            }
        }
    }
    for (section, empty) in [
        ("walls", site.walls.is_empty()),
        ("areas", site.areas.is_empty()),
        ("perception.kinds", site.perception_kinds.is_empty()),
    ] {
        if empty && !report.touched(&[section]) && report.origin.is_written(section) {
            let expected = format!("at least one section [{section}.<id>]");
            report.wrong(ProblemKind::MissingKey, section, "none", expected);
        }
    }
}

pub(super) fn geometry(site: &SiteConfig, report: &Report) {
    for wall in &site.walls {
        length(&format!("walls.{}.to_m", wall.id), &wall.line, report);
    }
    for lane in &site.lanes {
        lane_geometry(site, lane, report);
    }
    for (index, area) in site.areas.iter().enumerate() {
        let key = format!("areas.{}", area.id);
        for other in &site.areas[..index] {
            if area.region.overlaps(&other.region) {
                let problem = report.problem(
                    ProblemKind::Inconsistent,
                    &format!("{key}.region"),
                    format!("a region that overlaps area `{}`", other.id),
                    "areas that share no floor",
                );
                report.push(report.origin.also(
                    problem,
                    &format!("areas.{}.region", other.id),
                    "the other area",
                ));
            }
        }
        let Some(lane) = area.lane.as_deref().and_then(|id| site.lane(id)) else {
            continue;
        };
        let inside = area
            .region
            .clip(&lane.line)
            .map_or(0.0, |(enter, leave)| leave - enter);
        if inside <= 0.0 {
            report.wrong(
                ProblemKind::Inconsistent,
                &format!("{key}.lane"),
                format!("lane `{}`, which does not pass through the area", lane.id),
                "a lane through the area's region",
            );
        }
    }
}

fn length(key: &str, line: &Segment, report: &Report) {
    let (length_m, to) = (line.length_m(), line.b);
    if length_m < SHORTEST_M {
        report.wrong(
            ProblemKind::Inconsistent,
            key,
            format!("[{:?}, {:?}], {length_m} m from `from_m`", to.x_m, to.y_m),
            format!("an end at least {SHORTEST_M} m away"),
        );
    }
}

fn lane_geometry(site: &SiteConfig, lane: &Lane, report: &Report) {
    let key = format!("lanes.{}", lane.id);
    length(&format!("{key}.to_m"), &lane.line, report);
    for (name, end) in [("from_m", lane.line.a), ("to_m", lane.line.b)] {
        if site.area_at(end).is_none() {
            report.wrong(
                ProblemKind::Inconsistent,
                &format!("{key}.{name}"),
                format!("[{:?}, {:?}], which is in no area", end.x_m, end.y_m),
                "an end of the lane inside an area",
            );
        }
    }
    for wall in &site.walls {
        if lane.line.meets(&wall.line) {
            report.wrong(
                ProblemKind::Inconsistent,
                &format!("{key}.to_m"),
                format!("a lane into wall `{}`", wall.id),
                "a lane that no wall crosses",
            );
        }
    }
    let Some(wall) = lane.end_wall.as_deref().and_then(|id| site.wall(id)) else {
        return;
    };
    if distance_ahead(lane, wall).is_none() {
        report.wrong(
            ProblemKind::Inconsistent,
            &format!("{key}.end_wall"),
            format!("wall `{}`, which is not ahead of the lane's end", wall.id),
            "the wall that the lane runs up to",
        );
    }
}

/// From the lane's end straight on to the wall, metres.
fn distance_ahead(lane: &Lane, wall: &Wall) -> Option<f64> {
    let ahead_m = wall
        .line
        .ray_range_m(lane.line.b, lane.line.direction_rad())?;
    (ahead_m > 0.0).then_some(ahead_m)
}

/// Where robots start: inside the area of their first state, along its lane.
pub(super) fn starts(site: &SiteConfig, report: &Report) {
    let mut starting: BTreeMap<&str, u32> = BTreeMap::new();
    for (id, robot) in &site.robots {
        let key = format!("robots.{id}.start");
        let at = robot.start.position();
        let shown = format!("({:?}, {:?})", at.x_m, at.y_m);
        let Some(area) = site.area_at(at) else {
            let expected = "a start inside an area";
            report.wrong(
                ProblemKind::Inconsistent,
                &key,
                format!("{shown}, which is in no area"),
                expected,
            );
            continue;
        };
        let fsm = site.fsm.get(&robot.role);
        let first = fsm.and_then(|fsm| {
            fsm.state(robot.start_state.as_deref().unwrap_or(fsm.initial.as_str()))
        });
        if let Some(state) = first
            && state.area != area.id
            && site
                .area(&state.area)
                .is_some_and(|own| !own.region.contains(at))
        {
            report.wrong(
                ProblemKind::Inconsistent,
                &key,
                format!("{shown}, which is in area `{}`", area.id),
                format!(
                    "a start in area `{}` of its first state, `{}`",
                    state.area, state.name
                ),
            );
        }
        let count = starting.entry(&area.id).or_default();
        *count += 1;
        if *count > area.capacity {
            report.wrong(
                ProblemKind::Inconsistent,
                &key,
                format!("{count} robots that start in area `{}`", area.id),
                format!("at most its capacity, {}", area.capacity),
            );
        }
        let own = first.and_then(|state| state.lane.as_deref());
        let Some(lane) = own
            .or(area.lane.as_deref())
            .and_then(|lane| site.lane(lane))
        else {
            continue;
        };
        let off_m = lane.line.distance_m(at);
        if off_m > area.control.deviation_limit_m {
            report.wrong(
                ProblemKind::Inconsistent,
                &key,
                format!("{shown}, {off_m:.3} m from lane `{}`", lane.id),
                format!(
                    "at most the area's deviation limit, {} m",
                    area.control.deviation_limit_m
                ),
            );
        }
        let direction_rad = lane.line.direction_rad();
        let turned = wrap_angle(robot.start.theta_rad - direction_rad);
        if turned.abs() > FRAC_PI_4 {
            report.wrong(
                ProblemKind::Inconsistent,
                &format!("{key}.theta_rad"),
                format!("{:?}", robot.start.theta_rad),
                format!(
                    "within 45° of lane `{}`, which points to {:.4} rad",
                    lane.id, direction_rad
                ),
            );
        }
    }
}
