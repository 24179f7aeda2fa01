//! Records that are made up.

use config::SiteConfig;
use serde_json::json;
use sim::world::Pose;

use crate::record::{PathPoint, Record, RobotRecord, Span, StateChange, Wait};
use crate::report::specimens::{self, noise};
use crate::summary::{
    CoordinationSummary, DuringSummary, FiringSummary, Holding, Latency, MediatorSummary,
    PartSummary, RobotSummary,
};
use crate::testing::{net, site};

pub(super) fn empty(name: &str) -> Record {
    specimens::empty(name, site(name))
}

pub(super) fn threads() -> serde_json::Value {
    let thread = |period_us: u64, scale: f64, priority: u32| {
        json!({
            "cycles": 51_225, "overruns": 3, "period_us": period_us,
            "granted": { "policy": if priority > 0 { "fifo" } else { "normal" }, "priority": priority, "cores": "0,1" },
            "wakeup_us": { "p50": 40.0 * scale, "p99": 114.0 * scale, "p999": 557.0 * scale, "max": 5848.2 * scale },
            "exec_us": { "p50": 100.0 * scale, "p99": 212.0 * scale, "p999": 557.0 * scale, "max": 2655.0 * scale },
        })
    };
    json!({
        "communication": thread(50_000, 2.0, 0), "fieldbus": thread(1_000, 0.5, 80), "lidar": thread(0, 0.3, 60),
        "motion": thread(5_000, 0.7, 70), "navigation": thread(50_000, 1.0, 50),
    })
}

pub(super) fn member(id: &str, role: &str) -> RobotSummary {
    RobotSummary {
        id: id.to_owned(),
        laps: 2,
        distance_m: 35.12,
        min_clearance_m: 0.234,
        max_speed_m_s: 0.4,
        threads: threads(),
        rss_mib: Some(18.0),
        cpu_percent: Some(8.5),
        role: role.to_owned(),
        wanted: 2,
        done_s: Some(96.4),
        ..RobotSummary::default()
    }
}

/// A robot that goes round the corridor with a speed, from a start on its way of 18 m; it stands in some spans, and
/// its way may lead aside.
pub(super) fn driven(
    id: &str,
    role: &str,
    speed_m_s: f64,
    start_m: f64,
    end_s: f64,
    stands: &[(f64, f64)],
) -> RobotRecord {
    const ROUND_M: f64 = 17.14;
    let mut way_m = start_m;
    let mut path = Vec::new();
    let mut states: Vec<StateChange> = Vec::new();
    for index in 0..(end_s * 20.0) as usize {
        let at_s = index as f64 / 20.0;
        let stands = stands
            .iter()
            .any(|(from_s, to_s)| (*from_s..*to_s).contains(&at_s));
        let speed_m_s = if stands { 0.0 } else { speed_m_s };
        way_m += speed_m_s / 20.0;
        let on_m = way_m % ROUND_M;
        let (pose, state) = match on_m {
            on_m if on_m < 7.0 => (Pose::new(1.5 + on_m, -0.5, 0.0), "drive-1"),
            on_m if on_m < 8.57 => {
                let angle_rad = (on_m - 7.0) / 0.5;
                (
                    Pose::new(
                        8.5 + 0.5 * angle_rad.sin(),
                        -0.5 * angle_rad.cos(),
                        angle_rad,
                    ),
                    "turn-3",
                )
            }
            on_m if on_m < 15.57 => (
                Pose::new(8.5 - (on_m - 8.57), 0.5, std::f64::consts::PI),
                "drive-4",
            ),
            on_m => {
                let angle_rad = (on_m - 15.57) / 0.5;
                let theta_rad = std::f64::consts::PI + angle_rad;
                (
                    Pose::new(
                        1.5 - 0.5 * angle_rad.sin(),
                        0.5 * angle_rad.cos(),
                        theta_rad,
                    ),
                    "turn-7",
                )
            }
        };
        if states.last().is_none_or(|last| last.state != state) {
            states.push(StateChange {
                at_s,
                state: state.to_owned(),
                area: "1".to_owned(),
                skill: "follow".to_owned(),
                believed_m: [pose.x_m, pose.y_m],
            });
        }
        path.push(PathPoint {
            at_s,
            pose,
            speed_m_s,
            clearance_m: 0.4,
            in_contact: false,
        });
    }
    RobotRecord {
        id: id.to_owned(),
        role: role.to_owned(),
        model: "a robot".to_owned(),
        max_speed_m_s: 0.4,
        footprint: description::geometry::Footprint {
            front_m: 0.32,
            rear_m: 0.08,
            left_m: 0.15,
            right_m: 0.15,
        },
        path,
        states,
    }
}

/// Holdings of the areas on a robot's path, asked for a little before; one robot at a time has an area.
pub(super) fn holdings(site: &SiteConfig, robots: &[RobotRecord]) -> Vec<Holding> {
    let mut holdings: Vec<Holding> = Vec::new();
    for robot in robots {
        let mut area_before = "";
        for point in &robot.path {
            let area = site
                .area_at([point.pose.x_m, point.pose.y_m].into())
                .map_or("", |area| &area.id);
            if area == area_before {
                continue;
            }
            if let Some(last) = holdings.iter_mut().rev().find(|own| own.robot == robot.id) {
                last.released_s = Some(point.at_s + 0.9);
            }
            holdings.push(Holding {
                area: area.to_owned(),
                robot: robot.id.clone(),
                fence: holdings.len() as u64,
                requested_s: Some(point.at_s - 2.5),
                granted_s: point.at_s - 2.498,
                entered_s: Some(point.at_s),
                released_s: None,
                returned: false,
            });
            area_before = area;
        }
    }
    holdings.retain(|holding| !holding.area.is_empty());
    holdings.sort_by(|a, b| a.granted_s.total_cmp(&b.granted_s));
    holdings
}

pub(super) const FIRED: [&str; 13] = [
    "take-emergency",
    "take-normal",
    "slow-down",
    "send-aside",
    "hold",
    "aside",
    "pass",
    "go-on",
    "passed",
    "back",
    "let-emergency-go",
    "let-normal-go",
    "",
];

pub(super) fn coordination(
    number: u64,
    from_s: f64,
    took_s: f64,
    robots: [&str; 2],
) -> CoordinationSummary {
    let firings = FIRED
        .iter()
        .filter(|name| !name.is_empty())
        .enumerate()
        .map(|(index, name)| FiringSummary {
            transition: (*name).to_owned(),
            at_s: from_s + took_s * index as f64 / 12.0,
        })
        .collect();
    let part = |(role, robot): (&str, &str)| PartSummary {
        role: role.to_owned(),
        robot: robot.to_owned(),
    };
    CoordinationSummary {
        number,
        id: "overtaking".to_owned(),
        net: "overtaking".to_owned(),
        situation: net("overtaking").situations[0].id.clone(),
        robots: { ["emergency", "normal"].into_iter().zip(robots) }
            .map(part)
            .collect(),
        from_s,
        duration_s: Some(took_s),
        firings,
        marking: vec!["emergency-gone".to_owned(), "normal-gone".to_owned()],
    }
}

/// Two robots and one coordination.
pub(super) fn overtaking() -> Record {
    let mut record = empty("overtaking");
    let mut random = noise();
    record.about = "the emergency robot passes the normal one".to_owned();
    record.nets = vec![net("overtaking")];
    record.robots = vec![
        driven("amr-1", "normal", 0.2, 2.0, 100.0, &[(22.0, 40.0)]),
        driven("amr-2", "emergency", 0.4, 13.0, 100.0, &[(11.0, 20.0)]),
    ];
    record.holdings = holdings(&record.site, &record.robots);
    record.waits = vec![Wait {
        robot: "amr-2".to_owned(),
        area: "1".to_owned(),
        from_s: 10.0,
        to_s: Some(20.2),
        why: "area 1 is held by amr-1".to_owned(),
    }];
    record.mediator = vec![Span {
        from_s: 0.0,
        to_s: 100.0,
    }];
    record.grant_latency_ms = (0..400)
        .map(|_| 0.4 + 2.0 * random() * random() * random())
        .collect();
    record.command_latency_ms = (0..40)
        .map(|_| 0.6 + 6.0 * random() * random() * random())
        .collect();
    let summary = &mut record.summary;
    summary.coordinations = vec![coordination(1, 10.2, 34.0, ["amr-2", "amr-1"])];
    summary.seed = 1_234_567;
    summary.duration_s = 100.0;
    summary.robots = vec![member("amr-1", "normal"), member("amr-2", "emergency")];
    summary.mediator = Some(MediatorSummary {
        starts: 1,
        dropped: None,
        rss_mib: Some(14.0),
        cpu_percent: Some(1.5),
    });
    summary.grants = Latency::of(&record.grant_latency_ms);
    summary.commands = Latency::of(&record.command_latency_ms);
    summary.during = vec![DuringSummary {
        rule: "while amr-2 is in area 1, amr-1 stands in area 5".to_owned(),
        checked_s: 12.4,
        broken_s: 0.0,
    }];
    record
}
