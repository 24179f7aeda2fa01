//! The semantic map: references, and whether its geometry makes sense.

use std::collections::BTreeMap;
use std::f64::consts::{FRAC_PI_4, PI};

use crate::check::reference;
use crate::diagnostic::ProblemKind;
use crate::geometry::{distance_to_segment, segments_meet};
use crate::report::Report;
use crate::site::{Lane, MonitorKind, RegionRef, SiteConfig, Wall};

/// Shorter walls and lanes are typing mistakes.
const SHORTEST_M: f64 = 0.01;

pub(super) fn references(site: &SiteConfig, report: &Report) {
    let walls: Vec<&str> = site.walls.iter().map(|wall| wall.id.as_str()).collect();
    let lanes: Vec<&str> = site.lanes.iter().map(|lane| lane.id.as_str()).collect();
    let areas: Vec<&str> = site.areas.iter().map(|area| area.id.as_str()).collect();
    let zones: Vec<&str> = site
        .perception
        .iter()
        .map(|zone| zone.id.as_str())
        .collect();
    let kinds: Vec<&str> = site.perception_kinds.keys().map(String::as_str).collect();
    for lane in &site.lanes {
        if let Some(wall) = &lane.end_wall {
            reference(
                report,
                &format!("lanes.{}.end_wall", lane.id),
                wall,
                "wall",
                &walls,
            );
        }
    }
    for area in &site.areas {
        if let Some(lane) = &area.lane {
            reference(
                report,
                &format!("areas.{}.lane", area.id),
                lane,
                "lane",
                &lanes,
            );
        }
    }
    for zone in &site.perception {
        let key = format!("perception.zones.{}.kind", zone.id);
        reference(report, &key, &zone.kind, "perception kind", &kinds);
    }
    for monitor in &site.monitors {
        let key = |name: &str| format!("monitors.{}.{name}", monitor.event);
        if let MonitorKind::RegionReached { of, .. } = &monitor.kind {
            match of {
                RegionRef::Area(id) => reference(report, &key("area"), id, "area", &areas),
                RegionRef::Zone(id) => reference(report, &key("zone"), id, "zone", &zones),
                RegionRef::Own => {}
            }
        }
    }
    for (section, empty) in [
        ("walls", walls.is_empty()),
        ("areas", areas.is_empty()),
        ("perception.kinds", kinds.is_empty()),
    ] {
        if empty && !report.touched(&[section]) && report.origin.is_written(section) {
            let expected = format!("at least one section [{section}.<id>]");
            report.wrong(ProblemKind::MissingKey, section, "none", expected);
        }
    }
}

pub(super) fn geometry(site: &SiteConfig, report: &Report) {
    for wall in &site.walls {
        length(
            &format!("walls.{}.to_m", wall.id),
            wall.from_m,
            wall.to_m,
            report,
        );
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
            .clip(lane.from_m, lane.to_m)
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

fn length(key: &str, from_m: [f64; 2], to_m: [f64; 2], report: &Report) {
    let length_m = (to_m[0] - from_m[0]).hypot(to_m[1] - from_m[1]);
    if length_m < SHORTEST_M {
        report.wrong(
            ProblemKind::Inconsistent,
            key,
            format!("[{:?}, {:?}], {length_m} m from `from_m`", to_m[0], to_m[1]),
            format!("an end at least {SHORTEST_M} m away"),
        );
    }
}

fn lane_geometry(site: &SiteConfig, lane: &Lane, report: &Report) {
    let key = format!("lanes.{}", lane.id);
    length(&format!("{key}.to_m"), lane.from_m, lane.to_m, report);
    for (name, end_m) in [("from_m", lane.from_m), ("to_m", lane.to_m)] {
        if site.area_at(end_m).is_none() {
            report.wrong(
                ProblemKind::Inconsistent,
                &format!("{key}.{name}"),
                format!("[{:?}, {:?}], which is in no area", end_m[0], end_m[1]),
                "an end of the lane inside an area",
            );
        }
    }
    for wall in &site.walls {
        if segments_meet((lane.from_m, lane.to_m), (wall.from_m, wall.to_m)) {
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
pub(super) fn distance_ahead(lane: &Lane, wall: &Wall) -> Option<f64> {
    let (dx, dy) = direction(lane);
    let (ex, ey) = (wall.to_m[0] - wall.from_m[0], wall.to_m[1] - wall.from_m[1]);
    let (px, py) = (wall.from_m[0] - lane.to_m[0], wall.from_m[1] - lane.to_m[1]);
    let cross = dx * ey - dy * ex;
    if cross.abs() < 1e-9 {
        return None;
    }
    let ahead_m = (px * ey - py * ex) / cross;
    let along_wall = (px * dy - py * dx) / cross;
    (ahead_m > 0.0 && (0.0..=1.0).contains(&along_wall)).then_some(ahead_m)
}

/// The lane's unit vector.
pub(super) fn direction(lane: &Lane) -> (f64, f64) {
    let (dx, dy) = (lane.to_m[0] - lane.from_m[0], lane.to_m[1] - lane.from_m[1]);
    let length = dx.hypot(dy).max(f64::MIN_POSITIVE);
    (dx / length, dy / length)
}

/// Where robots start: inside the area of their first state, along its lane.
pub(super) fn starts(site: &SiteConfig, report: &Report) {
    let mut starting: BTreeMap<&str, u32> = BTreeMap::new();
    for (id, robot) in &site.robots {
        let key = format!("robots.{id}.start");
        let at_m = [robot.start.x_m, robot.start.y_m];
        let shown = format!("({:?}, {:?})", at_m[0], at_m[1]);
        let Some(area) = site.area_at(at_m) else {
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
                .is_some_and(|own| !own.region.contains(at_m))
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
        let off_m = distance_to_segment(at_m, lane.from_m, lane.to_m);
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
        let (dx, dy) = direction(lane);
        let turned = (robot.start.theta_rad - dy.atan2(dx) + PI).rem_euclid(2.0 * PI) - PI;
        if turned.abs() > FRAC_PI_4 {
            report.wrong(
                ProblemKind::Inconsistent,
                &format!("{key}.theta_rad"),
                format!("{:?}", robot.start.theta_rad),
                format!(
                    "within 45° of lane `{}`, which points to {:.4} rad",
                    lane.id,
                    dy.atan2(dx)
                ),
            );
        }
    }
}
