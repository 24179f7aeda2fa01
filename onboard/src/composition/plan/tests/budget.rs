//! The budget of lateness.

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
