//! The whole page: well-formed, bounded, and complete.

use config::{RobotConfig, SiteConfig};
use sim::world::{Pose, Truth, Twist};

use super::sheet::{LARGEST_BYTES, draw};
use crate::record::{PathPoint, Record, RobotRecord, StateChange};
use crate::report::site_svg;
use crate::report::specimens::{check_body, empty, noise};
use crate::scenario::Limits;
use crate::summary::{RobotSummary, Summary, Violation};
use crate::testing;
use crate::violation::ViolationKind;

/// The first record of a path.
const START_NS: u64 = 7_000_000_000;

fn svg(
    site: &SiteConfig,
    robot: &RobotConfig,
    path: &[Truth],
    changes: &[StateChange],
    summary: &Summary,
) -> String {
    let point = |truth: &Truth| PathPoint {
        at_s: (truth.time_ns as f64 - START_NS as f64) / 1e9,
        pose: truth.pose,
        speed_m_s: truth.twist.v_m_s,
        clearance_m: truth.clearance_m,
        in_contact: truth.in_contact,
    };
    let robot = RobotRecord {
        id: robot.identity.id.clone(),
        role: "normal".to_owned(),
        model: robot.identity.model.clone(),
        max_speed_m_s: robot.drive.limits.max_speed_m_s,
        footprint: robot.footprint,
        path: path.iter().map(point).collect(),
        states: changes.to_vec(),
    };
    let record = Record {
        limits: Limits {
            lateral_error_m: Some(0.1),
            ..Limits::default()
        },
        robots: vec![robot],
        summary: summary.clone(),
        ..empty("lap", site.clone())
    };
    draw(&record, &record.robots[0])
}

fn site() -> SiteConfig {
    testing::site("corridor")
}

fn robot() -> RobotConfig {
    testing::robot("amr-1")
}

fn summary(duration_s: f64) -> Summary {
    let robot = RobotSummary {
        id: "amr-1".to_owned(),
        laps: 3,
        wanted: 3,
        distance_m: 55.25,
        min_clearance_m: 0.4321,
        max_lateral_error_m: 0.0456,
        max_speed_m_s: 0.4,
        max_setpoint_rad_s: 8.0,
        rss_mib: Some(30.0),
        cpu_percent: Some(10.0),
        ..RobotSummary::default()
    };
    Summary {
        seed: 1_234_567,
        duration_s,
        robots: vec![robot],
        ..empty("lap", site()).summary
    }
}

fn truth(index: usize, x_m: f64, y_m: f64, theta_rad: f64) -> Truth {
    Truth {
        time_ns: START_NS + index as u64 * 20_000_000,
        pose: Pose::new(x_m, y_m, theta_rad),
        twist: Twist {
            v_m_s: 0.3,
            omega_rad_s: 0.0,
        },
        pivot_rad: 0.0,
        clearance_m: 0.5,
        min_clearance_m: 0.5,
        distance_m: 0.0,
        collisions: 0,
        run_into: 0,
        in_contact: false,
    }
}

/// Rounds on both lanes, at 50 Hz.
fn rounds(count: usize) -> Vec<Truth> {
    let drive = |index: usize| {
        let angle_rad = index as f64 / 2500.0 * std::f64::consts::TAU;
        let (sin, cos) = angle_rad.sin_cos();
        truth(
            index,
            5.0 + 4.0 * cos,
            (1.2 * sin).clamp(-0.5, 0.5),
            angle_rad + std::f64::consts::FRAC_PI_2,
        )
    };
    (0..count * 2500).map(drive).collect()
}

fn change(state: &str, skill: &str, x_m: f64, y_m: f64) -> StateChange {
    StateChange {
        at_s: 0.0,
        state: state.to_owned(),
        area: "1".to_owned(),
        skill: skill.to_owned(),
        believed_m: [x_m, y_m],
    }
}

fn violation(at_s: f64, detail: String) -> Violation {
    Violation {
        kind: ViolationKind::Clearance,
        robot: "amr-1".to_owned(),
        at_s,
        detail,
    }
}

/// Checks a file; returns its texts.
fn check_xml(file: &str) -> Vec<String> {
    let declaration = "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n";
    check_body(file.strip_prefix(declaration).expect("a declaration"))
}

fn has(texts: &[String], wanted: &str) -> bool {
    texts.iter().any(|text| text == wanted)
}

#[test]
fn a_run_is_drawn_with_all_that_was_asked_for() {
    let (site, robot) = (site(), robot());
    let changes = [
        change("drive-1", "follow-lane", 2.0, -0.5),
        change("search-2", "search-end", 5.5, -0.5),
        change("drive-1", "follow-lane", 2.01, -0.5),
        change("x", "", 3.0, 0.0),
    ];
    let file = svg(&site, &robot, &rounds(3), &changes, &summary(150.0));
    let texts = check_xml(&file);
    for area in &site.areas {
        assert!(has(&texts, &area.id), "area {}", area.id);
    }
    for figure in [
        "1234567", "150.0 s", "3", "55.25 m", "0", "0.432 m", "0.046 m", "done",
    ] {
        assert!(has(&texts, figure), "{figure}");
    }
    for label in [
        "follow-lane",
        "search-end",
        "start and end",
        "follow-lane: state drive-1, area 1, 2×",
    ] {
        assert!(has(&texts, label), "{label}");
    }
    assert!(
        !file.contains("state x"),
        "without a skill nothing is scheduled"
    );
    assert!(!file.contains("class=\"wrong\" d="));
}

#[test]
fn violations_are_red_on_map_and_charts() {
    let mut path = rounds(2);
    for truth in &mut path[1000..1100] {
        truth.clearance_m = 0.04;
    }
    let mut summary = summary(100.0);
    summary.violations.push(violation(
        20.0,
        "0.040 m, expected at least 0.1 m".to_owned(),
    ));
    let file = svg(&site(), &robot(), &path, &[], &summary);
    let texts = check_xml(&file);
    assert!(has(&texts, "done, 1 violation") && has(&texts, "0.040 m, expected at least 0.1 m"));
    for mark in [
        "class=\"hit\" cx=",
        "class=\"wrong\" d=",
        "class=\"over\" d=",
        "class=\"when\" d=",
    ] {
        assert!(file.contains(mark), "{mark}");
    }
}

#[test]
fn nothing_recorded_is_still_a_page() {
    let mut nothing = summary(0.0);
    nothing.robots.clear();
    nothing.outcome = "the robot ended by itself with exit status: 2".to_owned();
    let texts = check_xml(&svg(&site(), &robot(), &[], &[], &nothing));
    assert!(has(&texts, "nothing was recorded"));
    let mut empty = site();
    (empty.walls, empty.lanes, empty.areas, empty.perception) = Default::default();
    check_xml(&svg(&empty, &robot(), &[], &[], &nothing));
    check_xml(&svg(&empty, &robot(), &rounds(1)[..1], &[], &nothing));
}

#[test]
fn text_from_anywhere_is_escaped() {
    const EVIL: &str = "</text><script>\"a\" & 'b'\u{0}\u{1b}";
    let (mut site, mut robot, mut summary) = (site(), robot(), summary(50.0));
    site.name = EVIL.to_owned();
    site.areas[0].id = EVIL.to_owned();
    site.perception[0].id = EVIL.to_owned();
    site.perception[0].kind = EVIL.to_owned();
    robot.identity.model = EVIL.to_owned();
    summary.scenario = EVIL.to_owned();
    summary.outcome = EVIL.to_owned();
    summary.machine.processor = EVIL.to_owned();
    summary.violations.push(violation(3.0, EVIL.to_owned()));
    let file = svg(
        &site,
        &robot,
        &rounds(1),
        &[change(EVIL, EVIL, 2.0, -0.5)],
        &summary,
    );
    check_xml(&file);
    assert!(!file.contains("<script") && file.contains("&lt;script&gt;"));
    assert!(!file.contains(['\u{0}', '\u{1b}']));
}

#[test]
fn numbers_that_are_none_do_no_harm() {
    let mut path = rounds(1);
    path[10].pose.x_m = f64::NAN;
    path[11].twist.v_m_s = f64::INFINITY;
    path[12].clearance_m = f64::INFINITY;
    path[13].pose = Pose::new(1e300, -1e300, 0.0);
    path[14].time_ns = 0;
    path[15].time_ns = u64::MAX;
    let mut summary = summary(f64::NAN);
    summary.robots[0].min_clearance_m = f64::INFINITY;
    summary.violations.push(violation(f64::NAN, String::new()));
    let changes = [
        change("a", "b", f64::NAN, 0.0),
        change("c", "d", 1e300, f64::MIN),
    ];
    check_xml(&svg(&site(), &robot(), &path, &changes, &summary));
}

#[test]
fn the_file_stays_small_whatever_happens() {
    let (site, robot) = (site(), robot());
    let mut random = noise();
    let mut summary = summary(4000.0);
    let path: Vec<Truth> = (0..200_000)
        .map(|index| {
            let mut truth = truth(index, 10.0 * random(), 3.2 * random() - 1.6, 7.0 * random());
            truth.twist.v_m_s = random() - 0.5;
            truth.clearance_m = random();
            truth
        })
        .collect();
    let mut changes = Vec::new();
    for index in 0..5000 {
        let state = format!("state-{}", index % 100);
        changes.push(change(
            &state,
            &"long-skill-".repeat(20),
            10.0 * random(),
            3.2 * random() - 1.6,
        ));
        summary
            .violations
            .push(violation(4000.0 * random(), "near ".repeat(100)));
    }
    let file = svg(&site, &robot, &path, &changes, &summary);
    check_xml(&file);
    assert!(file.len() < LARGEST_BYTES, "{} bytes", file.len());
    let ordinary = svg(
        &site,
        &robot,
        &rounds(3),
        &changes[..20],
        &self::summary(150.0),
    );
    assert!(ordinary.len() < 200_000, "{} bytes", ordinary.len());
}

#[test]
fn a_site_alone_is_a_drawing_that_names_everything() {
    let site = site();
    let svg = site_svg(&site);
    assert!(svg.starts_with("<?xml") && svg.ends_with("</svg>\n") && svg.len() < LARGEST_BYTES);
    for area in &site.areas {
        assert!(svg.contains(&format!("{}: {}", area.id, area.control.manoeuvre.name())));
    }
    for lane in &site.lanes {
        assert!(svg.contains(&format!("lane {}", lane.id)), "{}", lane.id);
    }
    for wall in &site.walls {
        assert!(svg.contains(&format!("wall {}", wall.id)), "{}", wall.id);
    }
    assert!(svg.contains("amr-1 (normal)") && svg.contains("holds 1"));
}
