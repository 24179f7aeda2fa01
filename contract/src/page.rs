//! PROTOCOL.md says what the code does: its numbers and its bytes.

use std::fmt::Write as _;

use crate::client::LAST_NUMBER;
use crate::floor::{Floor, FloorArea};
use crate::timing::{
    ACQUIRED_WITHIN_NS, CANDIDATE_TIMEOUT_NS, DOUBLED_AFTER_NS, ENTERS_NO_MORE_NS,
    ENTERS_WITHIN_NS, LEASE_NS, LEVEL_PERIOD_NS, SILENT_AFTER_NS,
};
use crate::wire::{Access, Level, RobotReport};
use crate::{Message as _, VERSION, decode};

const PAGE: &str = include_str!("../PROTOCOL.md");

/// As the tables write it.
fn time(nanoseconds: u64) -> String {
    match (nanoseconds / 1_000_000, nanoseconds / 100_000_000) {
        (ms, 0..10) => format!("{ms} ms"),
        (_, tenths) if tenths.is_multiple_of(10) => format!("{} s", tenths / 10),
        (_, tenths) => format!("{}.{} s", tenths / 10, tenths % 10),
    }
}

#[test]
fn the_page_has_the_times_of_the_code() {
    for (what, nanoseconds) in [
        ("a level is sent at least every", LEVEL_PERIOD_NS),
        (
            "whoever was not heard for longer is silent",
            SILENT_AFTER_NS,
        ),
        ("lease: reports are as old as this, at most", LEASE_NS),
        (
            "from the last moment to reach in until it has or stands",
            ENTERS_WITHIN_NS,
        ),
        (
            "a silent robot enters nothing any more after",
            ENTERS_NO_MORE_NS,
        ),
        ("`acquire` is answered within", ACQUIRED_WITHIN_NS),
        (
            "two that speak at once are told to people after",
            DOUBLED_AFTER_NS,
        ),
        (
            "a process that was offered a session repeats it within",
            CANDIDATE_TIMEOUT_NS,
        ),
    ] {
        let row = format!("| {what} | {} |", time(nanoseconds));
        assert!(PAGE.contains(&row), "{row}");
    }
    let version = format!("# Protocol, version {VERSION}\n");
    assert!(PAGE.starts_with(&version), "{version}");
    assert_eq!(LAST_NUMBER, 1 << 62);
}

#[cfg(feature = "network")]
#[test]
fn the_page_has_the_longest_message() {
    let sentence = format!(
        "A message has at most {} bytes.",
        crate::network::LONGEST_MESSAGE
    );
    assert!(PAGE.contains(&sentence), "{sentence}");
}

#[test]
fn the_page_has_the_bytes_of_its_example() {
    let bay = FloorArea {
        id: "bay".into(),
        capacity: 2,
        min_m: [-0.5, 0.0],
        max_m: [3.0, 2.25],
    };
    let floor_hash = Floor::new(vec![bay]).hash();
    let report = RobotReport {
        version: Some(VERSION.into()),
        robot_id: "agv".into(),
        boot_epoch: 0x0123_4567_89AB_CDEF,
        sequence: 2,
        site: "hall".into(),
        mediator_epoch: 2,
        session: 2_000_001,
        located: true,
        fsm_state: "drive-2".into(),
        access: vec![Access {
            area: "3".into(),
            level: Some(Level {
                progress: 1,
                ..Level::default()
            }),
            fence: 0,
        }],
        mediator_sequence: 1,
        mediator_instance: 0x1234_5678_9ABC_DEF0,
        mediator_heard: true,
        floor_hash,
        ..RobotReport::default()
    };
    let bytes = report.encode_to_vec();
    let mut text = String::new();
    for (number, byte) in bytes.iter().enumerate() {
        let apart = match number {
            0 => "",
            _ if number.is_multiple_of(32) => "\n",
            _ => " ",
        };
        let _ = write!(text, "{apart}{byte:02x}");
    }
    assert!(PAGE.contains(&text), "{text}");
    let numbers = format!("boot_epoch: {}  ", report.boot_epoch);
    assert!(PAGE.contains(&numbers), "{numbers}");
    let numbers = format!("mediator_instance: {}  ", report.mediator_instance);
    assert!(PAGE.contains(&numbers), "{numbers}");
    let hash = format!("floor_hash: {floor_hash}\n");
    assert!(PAGE.contains(&hash), "{hash}");
    assert_eq!(decode::<RobotReport>(&bytes), Ok(report));
}
