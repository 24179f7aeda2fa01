//! What agrees, and what does not.

use config::NetTransition;

use super::*;
use crate::summary::{FiringSummary, Violation};
use crate::violation::ViolationKind;

/// A net in which `aside` and `slow` do not depend on each other, and `on` depends on both.
fn nets() -> Vec<NetConfig> {
    let mut net = crate::testing::net("overtaking");
    let transition = |id: &str, from: &[&str], to: &[&str]| {
        let [from, to] = [from, to].map(|own| own.iter().map(ToString::to_string).collect());
        let id = id.to_owned();
        NetTransition { id, from, to }
    };
    net.file.transitions = vec![
        transition("aside", &["a"], &["b"]),
        transition("slow", &["c"], &["d"]),
        transition("on", &["b", "d"], &["e"]),
    ];
    vec![net]
}

fn run() -> Summary {
    let holding = |robot: &str| Holding {
        area: "1".into(),
        robot: robot.into(),
        fence: 1,
        requested_s: None,
        granted_s: 1.0,
        entered_s: None,
        released_s: None,
        returned: false,
    };
    Summary {
        outcome: "done".into(),
        duration_s: 100.0,
        robots: vec![RobotSummary {
            id: "amr-1".into(),
            done_s: Some(90.0),
            max_lateral_error_m: 0.04,
            ..RobotSummary::default()
        }],
        areas: vec![AreaSummary {
            id: "1".into(),
            capacity: 1,
            owners: ["amr-1", "amr-2"].map(holding).to_vec(),
            longest_wait_s: 1.0,
        }],
        coordinations: vec![CoordinationSummary {
            number: 1,
            id: "overtaking".into(),
            net: "overtaking".into(),
            situation: "normal-ahead".into(),
            robots: Vec::new(),
            from_s: 10.0,
            duration_s: Some(20.0),
            firings: [("aside", 11.0), ("slow", 11.001), ("on", 19.0)]
                .map(fired)
                .to_vec(),
            marking: Vec::new(),
        }],
        ..Summary::default()
    }
}

fn fired((transition, at_s): (&str, f64)) -> FiringSummary {
    FiringSummary {
        transition: transition.into(),
        at_s,
    }
}

#[test]
fn what_is_nearly_the_same_agrees() {
    let (real, mut stepped) = (run(), run());
    stepped.duration_s = 101.9;
    stepped.robots[0].max_lateral_error_m = 0.06;
    let given_back = Holding {
        released_s: Some(1.001),
        ..stepped.areas[0].owners[1].clone()
    };
    stepped.areas[0].owners.insert(0, given_back);
    stepped.coordinations[0].firings.swap(0, 1);
    let pair = compare(&nets(), &real, &stepped);
    assert_eq!(pair.differences, [""; 0]);
    assert!(pair.compared >= 5);
}

#[test]
fn times_of_a_machine_that_stalled_are_not_compared() {
    let (mut real, mut stepped) = (run(), run());
    (real.duration_s, real.robots[0].done_s) = (107.0, Some(97.0));
    for (longest_ms, differences) in [(14.0, 2), (100.0, 0)] {
        real.stalls = Some(Stalls {
            count: 6,
            longest_ms,
            ..Stalls::default()
        });
        let pair = compare(&nets(), &real, &stepped);
        assert_eq!(pair.differences.len(), differences, "{pair:?}");
        assert_eq!(pair.stalled.is_some(), differences == 0);
    }
    stepped.areas[0].owners.reverse();
    let pair = compare(&nets(), &real, &stepped);
    assert!(pair.differences[0].contains("grants of area 1"));
}

#[test]
fn each_difference_is_told() {
    type Change = fn(&mut Summary);
    let collision = Violation {
        kind: ViolationKind::Collision,
        robot: "amr-1".into(),
        at_s: 1.0,
        detail: String::new(),
    };
    let mut hit = run();
    hit.violations.push(collision);
    let pair = compare(&nets(), &run(), &hit);
    assert!(
        pair.differences[0].starts_with("violations: real []"),
        "{pair:?}"
    );
    let changes: [(Change, &str); 12] = [
        (|run| run.outcome = "stuck".into(), "outcome"),
        (|run| run.robots[0].wanted = 2, "goals"),
        (|run| run.areas[0].owners.reverse(), "grants of area 1"),
        (|run| run.coordinations.clear(), "coordinations"),
        (|run| run.coordinations[0].firings.clear(), "firings of"),
        (|run| run.coordinations[0].firings.swap(1, 2), "firings of"),
        (|run| run.areas.clear(), "areas"),
        (
            |run| run.coordinations[0].duration_s = None,
            "duration of overtaking 1",
        ),
        (
            |run| run.coordinations[0].duration_s = Some(23.0),
            "duration of overtaking 1",
        ),
        (|run| run.duration_s = 104.0, "duration in seconds"),
        (|run| run.robots[0].done_s = None, "goal of amr-1"),
        (|run| run.robots[0].max_lateral_error_m = 0.2, "lateral"),
    ];
    for (change, told) in changes {
        let mut stepped = run();
        change(&mut stepped);
        let pair = compare(&nets(), &run(), &stepped);
        let [only] = pair.differences.as_slice() else {
            panic!("{told}: {:?}", pair.differences);
        };
        assert!(only.contains(told), "{only}");
    }
}

#[test]
fn an_order_that_hangs_on_whose_answer_comes_first_is_no_difference() {
    // What fires in the stepped run; and whether that agrees with aside at 11 s, slow at 11.001 s, on at 19 s.
    for (firings, agree) in [
        ([("slow", 11.0), ("aside", 12.5), ("on", 19.0)], true),
        // Each in its order, however near; and each as often.
        ([("slow", 11.0), ("on", 12.4), ("aside", 12.5)], false),
        ([("aside", 11.0), ("slow", 11.0), ("slow", 11.0)], false),
        ([("aside", 11.0), ("slow", 18.0), ("on", 18.0)], true),
    ] {
        let mut stepped = run();
        stepped.coordinations[0].firings = firings.map(fired).to_vec();
        let pair = compare(&nets(), &run(), &stepped);
        assert_eq!(pair.differences.is_empty(), agree, "{pair:?}");
    }
    // At once in neither.
    let (mut real, mut stepped) = (run(), run());
    real.coordinations[0].firings = [("aside", 11.0), ("slow", 11.2)].map(fired).to_vec();
    stepped.coordinations[0].firings = [("slow", 11.0), ("aside", 11.2)].map(fired).to_vec();
    let pair = compare(&nets(), &real, &stepped);
    assert!(pair.differences[0].contains("`aside` before `slow`"));
    // Of a net that nobody knows each order counts.
    let mut stepped = run();
    stepped.coordinations[0].firings.swap(0, 1);
    assert_eq!(compare(&[], &run(), &stepped).differences.len(), 1);
}

#[test]
fn orders_alone_are_no_agreement_unless_they_are_enough() {
    // How many of three agree, which of them were not timed, how many were to be; and whether that is agreement.
    for (agreeing, untimed, asked, agree) in [
        (3, &[][..], 3, true),
        (3, &[7], 3, false),
        (3, &[7, 9], 1, true),
        (3, &[5, 7, 9], 1, false),
        (3, &[5, 7, 9], 0, true),
        (3, &[], 4, false),
        (2, &[], 0, false),
    ] {
        let verdict = verdict(3, agreeing, untimed, asked);
        assert_eq!(verdict.is_ok(), agree, "{agreeing} {untimed:?} {asked}");
    }
}

#[test]
fn who_was_timed_too_seldom_hears_what_to_do() {
    let said = |untimed: &[u64], asked| {
        let Err(Failure::Failed(why)) = verdict(3, 3, untimed, asked) else {
            panic!("{untimed:?} {asked}");
        };
        why.to_string()
    };
    let stalled = said(&[7, 9], 2);
    for told in [
        "compared in 1 seeds, expected in 2",
        "seeds 7, 9: make them again",
    ] {
        assert!(stalled.contains(told), "{stalled}");
    }
    let few = said(&[], 4);
    assert!(few.contains("there are 3 real runs: make more"), "{few}");
}
