//! Figures in tables: robots, areas, latencies, threads.

use serde_json::{Value as Json, json};

use crate::summary::Latency;

use super::html::{Cell, Page, quantity, short_time};
use super::view::View;

/// The 99th percentile of both latencies should be less.
pub(super) const WANTED_P99_MS: f64 = 5.0;

/// One row for each robot.
pub(super) fn robots(page: &mut Page, view: &View<'_>) {
    page.element("h2", "Robots");
    let rows: Vec<Vec<Cell>> = view
        .record
        .summary
        .robots
        .iter()
        .map(|robot| {
            let waits = || {
                view.record
                    .waits
                    .iter()
                    .filter(|wait| wait.robot == robot.id)
            };
            let lasted = || {
                waits()
                    .filter_map(|wait| view.shown(wait.from_s, wait.to_s))
                    .map(|(from_s, to_s)| to_s - from_s)
            };
            let rounds = if robot.wanted == 0 {
                robot.laps.to_string()
            } else {
                format!("{} of {}", robot.laps, robot.wanted)
            };
            vec![
                Cell::new(&robot.id).swatch(view.class(&robot.id)),
                Cell::new(&robot.role),
                Cell::new(rounds).bad(robot.laps < robot.wanted),
                Cell::new(quantity(robot.done_s, 1, "s")),
                Cell::new(quantity(robot.distance_m, 1, "m")),
                Cell::new(quantity(robot.max_speed_m_s, 2, "m/s")),
                Cell::new(quantity(robot.min_clearance_m, 3, "m")),
                Cell::new(robot.collisions).bad(robot.collisions > 0),
                Cell::new(waits().count()),
                Cell::new(quantity(lasted().sum::<f64>(), 1, "s")),
                Cell::new(quantity(lasted().fold(0.0, f64::max), 1, "s")),
                Cell::new(format!(
                    "{} of {}",
                    robot.ethercat.lost_frames, robot.ethercat.cycles
                )),
                Cell::new(format!(
                    "{} of {}",
                    robot.lidar.dropped,
                    robot.lidar.scans + robot.lidar.dropped
                )),
                Cell::new(quantity(robot.rss_mib, 1, "MiB")),
                Cell::new(quantity(robot.cpu_percent, 1, "%")),
            ]
        })
        .collect();
    page.table(
        &[
            "<robot",
            "<role",
            "rounds",
            "done at",
            "distance",
            "fastest",
            "least clearance",
            "collisions",
            "waits",
            "waited",
            "longest",
            "frames lost",
            "scans dropped",
            "memory",
            "core",
        ],
        &rows,
    );
    if let Some(mediator) = &view.record.summary.mediator {
        let starts = match mediator.starts {
            1 => String::new(),
            more => format!(", started {more} times"),
        };
        page.element(
            "p class=\"soft\"",
            format!(
                "The mediator{starts}: {} of memory, {} of a core.",
                quantity(mediator.rss_mib, 1, "MiB"),
                quantity(mediator.cpu_percent, 1, "%")
            ),
        );
    } else {
        page.element("p class=\"soft\"", "No mediator ran.");
    }
}

/// What the judge found out about robots whose belief was looked at.
pub(super) fn figures(page: &mut Page, view: &View<'_>) {
    for robot in &view.record.summary.robots {
        let Some(Ok(Json::Object(figures))) = robot.figures.as_ref().map(serde_json::to_value)
        else {
            continue;
        };
        page.raw("<details>");
        page.element("summary", format!("All figures of {}", robot.id));
        let own = [
            ("faults", json!(robot.faults)),
            ("withheld", json!(robot.withheld)),
        ];
        let rows: Vec<Vec<Cell>> = { figures.into_iter() }
            .chain(own.map(|(name, value)| (name.to_owned(), value)))
            .map(|(name, value)| vec![Cell::new(name), Cell::new(value).long()])
            .collect();
        page.table(&["<figure", "<value"], &rows);
        page.raw("</details>\n");
    }
}

/// One row for each area.
pub(super) fn areas(page: &mut Page, view: &View<'_>) {
    let rows: Vec<Vec<Cell>> = view
        .record
        .site
        .areas
        .iter()
        .map(|area| {
            let held = || {
                view.record
                    .holdings
                    .iter()
                    .filter(|holding| holding.area == area.id)
            };
            let owned_s: f64 = held()
                .filter_map(|holding| view.shown(holding.granted_s, holding.released_s))
                .map(|(from_s, to_s)| to_s - from_s)
                .sum();
            let longest = view
                .record
                .waits
                .iter()
                .filter(|wait| wait.area == area.id)
                .filter_map(|wait| Some((view.shown(wait.from_s, wait.to_s)?, wait)))
                .max_by(|a, b| (a.0.1 - a.0.0).total_cmp(&(b.0.1 - b.0.0)));
            let share = 100.0 * owned_s / (view.end_s * f64::from(area.capacity.max(1)));
            let (waited, who, why) = longest.map_or_else(
                || ("–".to_owned(), String::new(), String::new()),
                |((from_s, to_s), wait)| {
                    (
                        quantity(to_s - from_s, 1, "s"),
                        wait.robot.clone(),
                        wait.why.clone(),
                    )
                },
            );
            let who = match who.is_empty() {
                true => Cell::new(""),
                false => Cell::new(&who).swatch(view.class(&who)),
            };
            vec![
                Cell::new(&area.id),
                Cell::new(area.capacity),
                Cell::new(held().count()),
                Cell::new(held().filter(|holding| holding.returned).count()),
                Cell::new(quantity(share, 0, "%")),
                Cell::new(waited),
                who,
                Cell::new(why).long(),
            ]
        })
        .collect();
    page.table(
        &[
            "<area",
            "holds",
            "grants",
            "given back unused",
            "owned",
            "longest wait",
            "<by",
            "<as the mediator told",
        ],
        &rows,
    );
}

/// Grants and commands.
pub(super) fn latencies(page: &mut Page, view: &View<'_>) {
    let row = |name: &str, latency: &Latency| {
        let late = latency.p99_ms.is_some_and(|p99_ms| p99_ms >= WANTED_P99_MS);
        vec![
            Cell::new(name),
            Cell::new(latency.count),
            Cell::new(short_time(latency.p50_ms)),
            Cell::new(short_time(latency.p99_ms)).bad(late),
            Cell::new(short_time(latency.max_ms)),
            Cell::new(format!("p99 under {}", short_time(WANTED_P99_MS))),
        ]
    };
    let summary = &view.record.summary;
    page.table(
        &["<from, to", "count", "p50", "p99", "max", "wanted"],
        &[
            row("request to grant, area free", &summary.grants),
            row("robot's flag to the mediator's command", &summary.commands),
        ],
    );
}

/// One row for each thread of each robot.
pub(super) fn threads(page: &mut Page, view: &View<'_>) {
    let mut rows = Vec::new();
    for robot in &view.record.summary.robots {
        for (name, thread) in robot.threads.as_object().into_iter().flatten() {
            let time = |group: &str, key: &str| short_time(micros(thread, group, key));
            let overruns = thread["overruns"].as_u64().unwrap_or(0);
            let mut row = vec![
                Cell::new(&robot.id).swatch(view.class(&robot.id)),
                Cell::new(name),
                Cell::new(granted(&thread["granted"])),
                Cell::new(
                    thread["period_us"]
                        .as_f64()
                        .filter(|period| *period > 0.0)
                        .map_or_else(
                            || "on data".to_owned(),
                            |period_us| short_time(period_us / 1e3),
                        ),
                ),
                Cell::new(thread["cycles"].as_u64().unwrap_or(0)),
                Cell::new(overruns),
            ];
            for group in ["wakeup_us", "exec_us"] {
                row.extend(["p50", "p99", "max"].map(|key| Cell::new(time(group, key))));
            }
            rows.push(row);
        }
    }
    page.table(
        &[
            "<robot",
            "<thread",
            "<scheduling, cores",
            "period",
            "cycles",
            "overruns",
            "wake-up p50",
            "p99",
            "max",
            "execution p50",
            "p99",
            "max",
        ],
        &rows,
    );
}

/// A figure of a thread in milliseconds; none where nothing was measured.
pub(super) fn micros(thread: &Json, group: &str, key: &str) -> Option<f64> {
    thread[group]["max"]
        .as_f64()
        .filter(|max_us| *max_us > 0.0)?;
    thread[group][key].as_f64().map(|value_us| value_us / 1e3)
}

fn granted(granted: &Json) -> String {
    let policy = granted["policy"].as_str().unwrap_or("unknown");
    let priority = granted["priority"].as_u64().unwrap_or(0);
    let cores = granted["cores"].as_str().unwrap_or("?");
    if priority == 0 {
        format!("{policy}, {cores}")
    } else {
        format!("{policy} {priority}, {cores}")
    }
}
