//! The budget of lateness.

use super::super::Budget;
use super::common::SITE;
use super::refused::{planned, robot};

/// Why a robot with these settings cannot drive the corridor.
fn fails_with(set: &[&str]) -> Vec<(String, String)> {
    let error = planned(&robot("amr-1", set), "some.toml", SITE).expect_err("refused");
    let problems = error.problems().iter();
    problems
        .map(|problem| (problem.key.clone(), problem.expected.clone()))
        .collect()
}

#[test]
fn more_lateness_than_the_tubes_plan_for() {
    let cases = [
        ("tubes.reaction_s=0.1", "at least 0.196 s"),
        ("drive.hold_ms=99", "drive.hold_ms 99 ms"),
        ("control.command_timeout_ms=200", "when motion tubes hang"),
        ("drive.setpoint_timeout_ms=150", "when control hangs"),
        (
            "ethercat.watchdog_ms=150",
            "when the drive or its bus hangs",
        ),
        (
            "drive.unpowered_deceleration_m_s2=0.5",
            "drive.unpowered_deceleration_m_s2 0.5",
        ),
        (
            "threads.navigation.at_least_ms=75",
            "when the drive or its bus hangs: threads.navigation.at_least_ms 75 ms",
        ),
    ];
    for (set, expected) in cases {
        let problems = fails_with(&[set]);
        let [(key, found)] = &problems[..] else {
            panic!("{set}: {problems:?}");
        };
        assert!(
            key == "tubes.reaction_s" && found.contains(expected),
            "{set}: {found}"
        );
    }
}

/// It brakes harder by itself than it is told to, and runs again just before it would.
#[test]
fn a_drive_that_hangs_for_less_than_its_watchdog() {
    let problems = fails_with(&[
        "drive.unpowered_deceleration_m_s2=8.0",
        "ethercat.watchdog_ms=220",
    ]);
    let [(key, found)] = &problems[..] else {
        panic!("{problems:?}");
    };
    let expected = "when the drive hangs for a moment";
    assert!(
        key == "tubes.reaction_s" && found.contains(expected),
        "{found}"
    );
}

#[test]
fn wheels_that_disobey_and_are_left_without_power_roll_farther() {
    let coasts = ["drive.emergency_bits=true"];
    let problems = fails_with(&coasts);
    let expected = "at most 0.030, half of tubes.by_hand_augment_m, also with the 0.013 that wheels without power roll farther (drive.emergency_bits)";
    assert_eq!(
        problems,
        [("drive.following_error_m".to_owned(), expected.to_owned())]
    );
    let soon = [coasts[0], "drive.following_error_m=0.015"];
    let found = planned(&robot("amr-1", &soon), "some.toml", SITE);
    assert!(found.is_ok(), "{found:?}");
}

#[test]
fn what_people_are_told_of_the_shipped_robot() {
    let plan = planned(&robot("amr-1", &[]), "some.toml", SITE).expect("valid");
    let text = Budget::check(&plan).expect("inside").to_string();
    let lines: Vec<String> = { text.lines() }
        .map(|line| line.split_whitespace().collect::<Vec<_>>().join(" "))
        .collect();
    let begin = [
        "to a stand from 0.4 m/s, in m and ms",
        "planned by the tubes 0.120 200 tubes.reaction_s 200 ms, then drive.stop_deceleration_m_s2 2",
        "nobody hangs 0.078 96 threads.navigation.at_least_ms 50 ms + threads.motion.period_us 5 ms + ",
        "motion tubes hang 0.118 196 control.command_timeout_ms 150 ms + ",
        "control hangs 0.096 141 threads.navigation.at_least_ms 50 ms + drive.setpoint_timeout_ms 50 ms + ",
        "the drive or its bus hangs 0.115 155 threads.navigation.at_least_ms 50 ms + ",
        "the drive hangs for a moment 0.110 176 threads.navigation.at_least_ms 50 ms + ",
        "no scan comes 250 lidar.scan_timeout_ms",
        "wheels do not obey 0.020 drive.following_error_m, of 0.030 ",
    ];
    assert_eq!(lines.len(), begin.len(), "{text}");
    for (line, begin) in lines.iter().zip(begin) {
        assert!(line.starts_with(begin), "{line}");
    }
}

#[test]
fn wheels_that_may_disobey_farther_and_scans_that_may_be_missed_longer_than_anybody_plans_for() {
    for (set, key, expected) in [
        (
            "drive.following_error_m=0.04",
            "drive.following_error_m",
            "at most 0.030, half of tubes.by_hand_augment_m",
        ),
        (
            "lidar.scan_timeout_ms=600",
            "lidar.scan_timeout_ms",
            "at most 5 scans, 500 ms",
        ),
    ] {
        let problems = fails_with(&[set]);
        assert_eq!(problems, [(key.to_owned(), expected.to_owned())]);
    }
}

#[test]
fn a_robot_that_would_enter_an_area_long_after_its_lease() {
    let slow = robot("amr-1", &["navigation.deceleration_m_s2=0.1"]);
    let managed = SITE.replace("\nmanaged = false\n", "\nmanaged = true\n");
    let error = planned(&slow, "some.toml", &managed).expect_err("refused");
    let [problem] = error.problems() else {
        panic!("{error:?}");
    };
    assert_eq!(problem.key, "navigation.deceleration_m_s2");
    assert!(
        problem.expected.contains("at least 0.16")
            && problem.expected.contains("within 3900 ms from 0.4 m/s"),
        "{}",
        problem.expected
    );
    // Without a mediator nobody else drives there.
    assert!(planned(&slow, "some.toml", SITE).is_ok());
}

/// Where no mediator manages areas it may do both.
#[test]
fn a_robot_that_would_leave_its_lane_or_brake_late_before_a_border() {
    let managed = SITE.replace("\nmanaged = false\n", "\nmanaged = true\n");
    for (set, expected) in [
        ("drive.lag_ms=65", "at most 64 ms"),
        ("tubes.detour_curvature_1_m=4", "0 where a mediator manages"),
    ] {
        let key = set.split('=').next().expect("a key");
        let robot = robot("amr-1", &[set]);
        let error = planned(&robot, "some.toml", &managed).expect_err("refused");
        let found = error.problems().iter().find(|problem| problem.key == key);
        let found = found.unwrap_or_else(|| panic!("{error:?}"));
        assert!(found.expected.contains(expected), "{}", found.expected);
        let alone = planned(&robot, "some.toml", SITE);
        let alone = alone
            .err()
            .map_or(Vec::new(), |error| error.problems().to_vec());
        assert!(alone.iter().all(|problem| problem.key != key), "{alone:?}");
    }
}

#[test]
fn timeouts_that_a_healthy_robot_runs_into() {
    for (set, key) in [
        (
            "control.command_timeout_ms=90",
            "control.command_timeout_ms",
        ),
        ("drive.setpoint_timeout_ms=9", "drive.setpoint_timeout_ms"),
        ("lidar.scan_timeout_ms=150", "lidar.scan_timeout_ms"),
    ] {
        let problems = fails_with(&[set]);
        assert!(
            problems.len() == 1 && problems[0].0 == key,
            "{set}: {problems:?}"
        );
    }
}
