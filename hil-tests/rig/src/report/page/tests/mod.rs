//! Whole pages of constructed records: well-formed, bounded, complete.

mod checks;
mod nets;
mod records;

use sim::world::Pose;

use super::whole::{self, LARGEST_BYTES};
use crate::record::{Incident, RobotRecord, Span, Wait};
use crate::report::specimens::noise;
use crate::stalls::Stalls;
use crate::summary::{Spoiled, Violation};
use crate::violation::ViolationKind;
use checks::{count, drawing, page};
use records::{coordination, driven, empty, holdings, overtaking};
use serde_json::json;

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
    record.summary.coordinations.clear();
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
fn what_went_wrong_comes_first() {
    let mut record = overtaking();
    record.summary.outcome = "amr-1 was not done in time".to_owned();
    record.summary.violations.push(Violation {
        kind: ViolationKind::EntryWithoutGrant,
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
    record.summary.coordinations = (0..60_u32)
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
            kind: ViolationKind::Collision,
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
    assert!(whole::html(&record).len() < LARGEST_BYTES / 2);
}

#[test]
fn a_machine_that_stalled_is_told_of() {
    let mut record = overtaking();
    assert!(!page(&record).0.contains("machine stalled"));
    let stalls = |count, longest_ms| Stalls {
        count,
        longest_ms,
        ..Stalls::default()
    };
    record.summary.stalls = Some(stalls(23, 31.4));
    record.summary.spoiled = Some(Spoiled {
        reason: "no robot has moved".to_owned(),
        stalls: stalls(99, 77.0),
    });
    let (page, _) = page(&record);
    for told in [
        "23 times, 31 ms at most",
        "no robot has moved (the machine stalled 99 times, 77 ms at most)",
    ] {
        assert!(page.contains(told), "{told}");
    }
}

#[test]
fn names_cannot_break_the_page() {
    const ODD: &str = "a<b & \"c\" '>]]\u{1b}";
    let mut record = overtaking();
    record.summary.scenario = ODD.to_owned();
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
    for firing in &mut record.summary.coordinations[0].firings {
        firing.transition.push_str(ODD);
    }
    let summary = &mut record.summary;
    (summary.outcome, summary.machine.processor) = (ODD.to_owned(), ODD.to_owned());
    summary.robots[0].threads = json!({ ODD: { "granted": { "policy": ODD } }, "none": 3 });
    summary.violations.push(Violation {
        kind: ViolationKind::During,
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
        record.summary.robots[0].min_clearance_m = odd;
    }
    let coordination = &mut record.summary.coordinations[0];
    coordination.firings[2].at_s = f64::NAN;
    coordination.duration_s = Some(-13.2);
    page(&record);
}
