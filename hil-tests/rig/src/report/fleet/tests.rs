//! Whole pages of constructed records: well-formed, bounded, complete.

use config::{NetConfig, SiteConfig};
use serde_json::json;
use sim::world::Pose;

use super::super::tests::check_body;
use super::LARGEST_BYTES;
use crate::one_robot::summary::{Machine, RobotSummary, Violation};
use crate::record::{
    CoordinationRecord, Holding, Incident, PathPoint, Record, RobotRecord, Span, StateChange, Wait,
};
use crate::summary::{DuringSummary, FleetSummary, Latency, MediatorSummary, MemberSummary};

const FILES: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../config");

fn site(name: &str) -> SiteConfig {
    config::load_site(format!("{FILES}/sites/{name}.toml"), &[]).expect("the site is good")
}

fn net(name: &str) -> NetConfig {
    config::load_net(format!("{FILES}/nets/{name}.toml")).expect("the net is good")
}

/// Repeatable numbers from 0 to 1.
fn noise() -> impl FnMut() -> f64 {
    let mut state = 1_u64;
    move || {
        state = state
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        (state >> 11) as f64 / (1_u64 << 53) as f64
    }
}

fn threads() -> serde_json::Value {
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

fn member(id: &str, role: &str) -> MemberSummary {
    MemberSummary {
        robot: RobotSummary {
            id: id.to_owned(),
            laps: 2,
            distance_m: 35.12,
            min_clearance_m: 0.234,
            max_speed_m_s: 0.4,
            threads: threads(),
            rss_mib: 18.0,
            cpu_percent: 8.5,
            ..RobotSummary::default()
        },
        role: role.to_owned(),
        wanted: 2,
        done_s: Some(96.4),
    }
}

fn empty(site_name: &str) -> Record {
    Record {
        scenario: site_name.to_owned(),
        about: String::new(),
        site: site(site_name),
        nets: Vec::new(),
        robots: Vec::new(),
        holdings: Vec::new(),
        waits: Vec::new(),
        coordinations: Vec::new(),
        mediator: Vec::new(),
        incidents: Vec::new(),
        grant_latency_ms: Vec::new(),
        command_latency_ms: Vec::new(),
        summary: FleetSummary {
            scenario: site_name.to_owned(),
            outcome: "done".to_owned(),
            seed: 0,
            duration_s: 0.0,
            machine: Machine {
                processor: "some processor".to_owned(),
                cores: 2,
                kernel: "6.1".to_owned(),
            },
            robots: Vec::new(),
            mediator: None,
            areas: Vec::new(),
            coordinations: Vec::new(),
            grants: Latency::default(),
            commands: Latency::default(),
            during: Vec::new(),
            violations: Vec::new(),
        },
    }
}

/// A robot that goes round the corridor with a speed, from a start on its way of 18 m; it stands in some spans, and
/// its way may lead aside.
fn driven(
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
            });
        }
        path.push(PathPoint {
            at_s,
            pose,
            speed_m_s,
            clearance_m: 0.4,
        });
    }
    RobotRecord {
        id: id.to_owned(),
        role: role.to_owned(),
        footprint: config::Footprint {
            front_m: 0.32,
            rear_m: 0.08,
            left_m: 0.15,
            right_m: 0.15,
        },
        path,
        states,
    }
}

/// Holdings of the areas on a robot's path, asked for a little before; an area is had by one at a time.
fn holdings(site: &SiteConfig, robots: &[RobotRecord]) -> Vec<Holding> {
    let mut holdings: Vec<Holding> = Vec::new();
    for robot in robots {
        let mut area_before = "";
        for point in &robot.path {
            let area = site
                .area_at([point.pose.x_m, point.pose.y_m])
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

const FIRED: [&str; 13] = [
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

fn coordination(number: u64, from_s: f64, took_s: f64, robots: [&str; 2]) -> CoordinationRecord {
    let firings: Vec<(String, f64)> = FIRED
        .iter()
        .filter(|name| !name.is_empty())
        .enumerate()
        .map(|(index, name)| ((*name).to_owned(), from_s + took_s * index as f64 / 12.0))
        .collect();
    CoordinationRecord {
        number,
        id: "overtaking".to_owned(),
        net: "overtaking".to_owned(),
        situation: net("overtaking").situations[0].id.clone(),
        robots: vec![
            ("emergency".to_owned(), robots[0].to_owned()),
            ("normal".to_owned(), robots[1].to_owned()),
        ],
        from_s,
        to_s: Some(from_s + took_s),
        firings,
        marking: vec!["emergency-gone".to_owned(), "normal-gone".to_owned()],
    }
}

/// Two robots and one coordination.
fn overtaking() -> Record {
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
    record.coordinations = vec![coordination(1, 10.2, 34.0, ["amr-2", "amr-1"])];
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
    summary.seed = 1_234_567;
    summary.duration_s = 100.0;
    summary.robots = vec![member("amr-1", "normal"), member("amr-2", "emergency")];
    summary.mediator = Some(MediatorSummary {
        starts: 1,
        rss_mib: 14.0,
        cpu_percent: 1.5,
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

/// The page of a record, which is in order; and all of its texts.
fn page(record: &Record) -> (String, Vec<String>) {
    let page = super::html(record);
    let body = page
        .strip_prefix("<!DOCTYPE html>\n")
        .expect("it says what it is");
    let texts = check_body(body);
    for outside in [
        "http:", "https:", "src=", "<script", "@import", "url(h", "NaN", "inf ",
    ] {
        assert!(!page.contains(outside), "{outside}");
    }
    assert!(page.len() < LARGEST_BYTES, "{} bytes", page.len());
    (page, texts)
}

fn count(page: &str, wanted: &str) -> usize {
    page.matches(wanted).count()
}

/// The drawing of a class.
fn drawing<'a>(page: &'a str, class: &str) -> &'a str {
    let begin = page
        .find(&format!("<svg class=\"{class}\""))
        .expect("it is drawn");
    let end = page[begin..].find("</svg>").expect("it ends");
    &page[begin..begin + end]
}

#[test]
fn a_page_says_what_happened() {
    let record = overtaking();
    let (page, texts) = page(&record);
    for wanted in [
        "overtaking",
        "done",
        "100.0\u{a0}s",
        "1234567",
        "1 of 1",
        "35.1\u{a0}m",
        "0.234\u{a0}m",
        "2 of 2",
        "amr-1 (normal)",
        "amr-2 (emergency)",
        "area 1 is held by amr-1",
        "fieldbus",
        "fifo 80, 0,1",
        "10.2\u{a0}s",
        "emergency: amr-2, normal: amr-1",
        "some processor, 2 cores, Linux 6.1",
        "while amr-2 is in area 1, amr-1 stands in area 5: true throughout the 12.4\u{a0}s in which it had to be.",
    ] {
        assert!(texts.iter().any(|text| text == wanted), "{wanted}");
    }
    for (figure, class) in ["map", "spacetime", "petri", "latencies", "threads"]
        .iter()
        .enumerate()
    {
        assert_eq!(
            count(&page, &format!("<svg class=\"{class}\"")),
            1,
            "{figure}: {class}"
        );
    }
    for figure in 1..=6 {
        assert_eq!(count(&page, &format!("Figure {figure}.")), 1, "{figure}");
    }
    assert_eq!(count(&page, "class=\"badge well\""), 1);
    assert!(!page.contains("What went wrong"));
}

#[test]
fn owners_are_solid_where_they_were_inside_and_hatched_while_they_waited() {
    let mut record = overtaking();
    let mut holding = record.holdings[0].clone();
    (holding.area, holding.robot) = ("5".to_owned(), "amr-2".to_owned());
    holding.requested_s = Some(20.0);
    (holding.granted_s, holding.entered_s, holding.released_s) = (30.0, Some(40.0), None);
    record.holdings = vec![holding];
    record.waits.clear();
    record.coordinations.clear();
    let (page, _) = page(&record);
    let drawn = drawing(&page, "spacetime");
    let width_px = |class: &str| -> f64 {
        let rect = drawn
            .split('<')
            .find(|tag| tag.starts_with(&format!("rect class=\"{class}\"")));
        let (_, width) = rect
            .and_then(|rect| rect.split_once("width=\""))
            .expect("it is drawn");
        width
            .split('"')
            .next()
            .and_then(|width| width.parse().ok())
            .expect("a number")
    };
    // 10 s of asking, 70 s of having until the end, of which 60 s inside.
    let second_px = width_px("ask") / 10.0;
    assert!((width_px("hold") / second_px - 70.0).abs() < 0.2);
    assert!((width_px("own") / second_px - 60.0).abs() < 0.2);
    assert!(drawn.contains("amr-2 waited 10.00 s for area 5"));
}

#[test]
fn more_owners_than_an_area_holds_are_marked() {
    let mut record = overtaking();
    for holding in &mut record.holdings {
        holding.area = "5".to_owned();
    }
    record.holdings.truncate(2);
    for holding in &mut record.holdings {
        (holding.granted_s, holding.released_s) = (10.0, Some(20.0));
    }
    let (page, _) = page(&record);
    assert_eq!(
        count(drawing(&page, "spacetime"), "more than the area holds"),
        1
    );
}

#[test]
fn a_net_is_drawn_with_its_marking_and_the_order_of_its_firings() {
    let record = overtaking();
    let (page, _) = page(&record);
    let drawn = drawing(&page, "petri");
    let net = &record.nets[0];
    for place in net.places.iter().filter(|place| !place.about.is_empty()) {
        assert!(
            drawn.contains(&format!("<title>{}: ", place.id)),
            "{}",
            place.id
        );
    }
    for transition in &net.transitions {
        assert!(
            drawn.contains(&format!(">{}</text>", transition.id)),
            "{}",
            transition.id
        );
    }
    assert_eq!(
        count(drawn, "class=\"token\""),
        net.situations[0].marked.len()
    );
    let arcs: usize = net
        .transitions
        .iter()
        .map(|own| own.from.len() + own.to.len())
        .sum();
    // A token that is put back is one arc with two tips.
    let tips: usize = drawn
        .match_indices("class=\"tip\"")
        .map(|(at, _)| count(drawn[at..].lines().next().unwrap_or(""), "Z"))
        .sum();
    assert_eq!(tips + count(drawn, "class=\"iotip\""), arcs);
    for (index, name) in FIRED.iter().take(12).enumerate() {
        assert_eq!(count(drawn, "class=\"nrtext\" x="), 12, "{name}");
        assert!(drawn.contains(&format!(">{}</text>", index + 1)), "{name}");
    }
    // The pale ones are the transitions of the other situation, with their arcs.
    let pale = net
        .transitions
        .iter()
        .filter(|own| !FIRED.contains(&own.id.as_str()));
    assert_eq!(
        count(drawn, ">take-parked</text>") + count(drawn, ">stay-aside</text>"),
        pale.count()
    );
    assert!(drawn.contains("class=\"never\""));
    // Ports have the colours of the robots in the roles: `emergency` is amr-2, the second.
    let port = drawn
        .find(">emergency.acquire</text>")
        .expect("it is drawn");
    let group = drawn[..port].rfind("<g class=\"").expect("a group");
    assert!(drawn[group..].starts_with("<g class=\"r1\">"));
}

#[test]
fn a_net_that_never_ran_or_is_too_large_is_told() {
    let mut record = empty("t-junction");
    record.nets = vec![net("t-junction"), net("docking")];
    let (sound, texts) = page(&record);
    assert_eq!(count(&sound, "<svg class=\"petri\""), 2);
    assert_eq!(
        texts.iter().filter(|text| *text == "It never ran.").count(),
        2
    );
    let copies = record.nets[0].transitions.clone();
    for copy in 0..100 {
        record.nets[0]
            .transitions
            .extend(copies.iter().cloned().map(|mut own| {
                own.id = format!("{}-{copy}", own.id);
                own
            }));
    }
    let (large, _) = page(&record);
    assert_eq!(count(&large, "<svg class=\"petri\""), 1);
    assert!(large.contains("The net is too large to be drawn here"));
}

#[test]
fn what_went_wrong_comes_first() {
    let mut record = overtaking();
    record.summary.outcome = "amr-1 was not done in time".to_owned();
    record.summary.violations.push(Violation {
        kind: "entry-without-grant".to_owned(),
        robot: "amr-2".to_owned(),
        at_s: 15.5,
        detail: "0.12 m of it in area 1, which amr-1 holds".to_owned(),
    });
    record.summary.during[0].broken_s = 0.4;
    record.incidents.push(Incident {
        at_s: 31.0,
        what: "the mediator was killed".to_owned(),
    });
    record.mediator = vec![
        Span {
            from_s: 0.0,
            to_s: 31.0,
        },
        Span {
            from_s: 33.0,
            to_s: 100.0,
        },
    ];
    let (page, texts) = page(&record);
    for wanted in [
        "amr-1 was not done in time, 1 violation",
        "entry without grant",
        "at 15.5\u{a0}s, amr-2: 0.12 m of it in area 1, which amr-1 holds",
        "while amr-2 is in area 1, amr-1 stands in area 5: not true for 0.4\u{a0}s of 12.4\u{a0}s.",
        "Done to the run: the mediator was killed (31.0\u{a0}s).",
    ] {
        assert!(texts.iter().any(|text| text == wanted), "{wanted}");
    }
    assert!(!page.contains("badge well"));
    assert_eq!(count(drawing(&page, "map"), "class=\"hit\""), 1);
    let drawn = drawing(&page, "spacetime");
    assert_eq!(
        [
            count(drawn, "class=\"when\""),
            count(drawn, "class=\"off\"")
        ],
        [1, 1]
    );
}

#[test]
fn nothing_at_all_is_a_page() {
    for name in ["overtaking", "docking", "t-junction", "corridor"] {
        let (page, _) = page(&empty(name));
        assert!(page.contains("No mediator ran.") && page.contains("none was measured"));
    }
}

#[test]
fn robots_that_never_moved_are_drawn_where_they_stood() {
    let mut record = overtaking();
    for robot in &mut record.robots {
        for point in &mut robot.path {
            (point.pose, point.speed_m_s) = (Pose::new(3.0, 0.5, 0.0), 0.0);
        }
    }
    record.robots.push(RobotRecord {
        id: "amr-3".to_owned(),
        path: Vec::new(),
        states: Vec::new(),
        ..record.robots[0].clone()
    });
    let (page, texts) = page(&record);
    assert!(texts.iter().any(|text| text == "amr-1 start, end"));
    assert!(page.contains("stood 100 s from 0 s") && page.contains("amr-3 (normal)"));
}

#[test]
fn a_long_run_of_three_stays_small() {
    let mut record = overtaking();
    let end_s = 1_200.0;
    record.robots = ["amr-1", "amr-2", "amr-3"]
        .iter()
        .zip([0.2, 0.4, 0.3])
        .map(|(id, speed_m_s)| {
            driven(
                id,
                "normal",
                speed_m_s,
                15.0 * speed_m_s,
                end_s,
                &[(50.0, 70.0)],
            )
        })
        .collect();
    record.holdings = holdings(&record.site, &record.robots);
    assert!(record.holdings.len() > 300);
    record.coordinations = (0..60_u32)
        .map(|index| {
            coordination(
                index.into(),
                f64::from(index) * 20.0,
                15.0,
                ["amr-2", "amr-1"],
            )
        })
        .collect();
    record.summary.duration_s = end_s;
    let mut random = noise();
    for _ in 0..20_000 {
        record.grant_latency_ms.push(10.0 * random());
        record.summary.violations.push(Violation {
            kind: "collision".to_owned(),
            robot: "amr-3".to_owned(),
            at_s: end_s * random(),
            detail: "near ".repeat(20),
        });
        let from_s = end_s * random();
        record.waits.push(Wait {
            robot: "amr-1".to_owned(),
            area: "4".to_owned(),
            from_s,
            to_s: Some(from_s + 0.2),
            why: "area 4 is held by amr-2".to_owned(),
        });
    }
    let (page, _) = page(&record);
    assert!(
        page.contains("more: see summary.json") && page.contains("more runs are in summary.json")
    );
    // Without what should not happen it is much smaller.
    record.summary.violations.clear();
    record.waits.clear();
    assert!(super::html(&record).len() < LARGEST_BYTES / 2);
}

#[test]
fn names_cannot_break_the_page() {
    const ODD: &str = "a<b & \"c\" '>]]\u{1b}";
    let mut record = overtaking();
    record.scenario = ODD.to_owned();
    record.about = ODD.to_owned();
    for robot in &mut record.robots {
        robot.id.push_str(ODD);
        robot.role = ODD.to_owned();
        robot
            .states
            .iter_mut()
            .for_each(|change| change.state.push_str(ODD));
    }
    for holding in &mut record.holdings {
        holding.robot.push_str(ODD);
    }
    for area in &mut record.site.areas {
        area.id.push_str(ODD);
    }
    for holding in &mut record.holdings {
        holding.area.push_str(ODD);
    }
    record.waits[0].why = ODD.to_owned();
    let net = &mut record.nets[0];
    net.about = Some(ODD.to_owned());
    net.places
        .iter_mut()
        .for_each(|place| place.about.push_str(ODD));
    net.transitions
        .iter_mut()
        .for_each(|own| own.id.push_str(ODD));
    for (transition, _) in &mut record.coordinations[0].firings {
        transition.push_str(ODD);
    }
    let summary = &mut record.summary;
    (summary.outcome, summary.machine.processor) = (ODD.to_owned(), ODD.to_owned());
    summary.robots[0].robot.threads = json!({ ODD: { "granted": { "policy": ODD } }, "none": 3 });
    summary.violations.push(Violation {
        kind: ODD.to_owned(),
        robot: ODD.to_owned(),
        at_s: 3.0,
        detail: ODD.to_owned(),
    });
    let (page, _) = page(&record);
    assert!(
        !page.contains("a<b") && page.contains("a&lt;b &amp; &quot;c&quot; &apos;&gt;]]\u{fffd}")
    );
}

#[test]
fn odd_numbers_leave_gaps_and_no_more() {
    let mut record = overtaking();
    for (index, odd) in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, -1e300, 1e300]
        .into_iter()
        .enumerate()
    {
        let point = &mut record.robots[0].path[100 * index + 7];
        (point.pose.x_m, point.speed_m_s) = (odd, odd);
        // Unlike `clamp` this leaves no NaN.
        let at_least = odd.max(-5.0);
        record.robots[1].path[100 * index].at_s = at_least.min(50.0);
        record.holdings[index].granted_s = if odd.is_finite() { 5.0 } else { odd };
        record.holdings[index].requested_s = Some(odd);
        record.holdings[index].released_s = Some(odd).filter(|odd| *odd < 1e200);
        record.grant_latency_ms.push(odd);
        record.waits[0].from_s = odd;
        record.summary.robots[0].robot.min_clearance_m = odd;
    }
    record.coordinations[0].firings[2].1 = f64::NAN;
    record.coordinations[0].to_s = Some(-3.0);
    page(&record);
}
