//! `rig bench` as a program: what it prints and leaves, not how fast anything is.

use std::path::Path;
use std::process::{Command, Output, Stdio};

use serde_json::Value as Json;

use crate::programs::late::once_more_if_late;
use crate::programs::turn::Turn;

/// `rig bench` with these arguments, and temporary files of its own.
fn bench(folder: &Path, arguments: &[&str]) -> (Output, String) {
    let scratch = folder.join("tmp");
    std::fs::create_dir_all(&scratch).expect("a folder");
    let output = Command::new(env!("CARGO_BIN_EXE_rig"))
        .arg("bench")
        .args(arguments)
        .arg("--out")
        .arg(folder.join("out"))
        .env("TMPDIR", &scratch)
        .current_dir(concat!(env!("CARGO_MANIFEST_DIR"), "/../.."))
        .stdin(Stdio::null())
        .output()
        .expect("the program starts");
    let text = [&output.stdout, &output.stderr].map(|bytes| String::from_utf8_lossy(bytes));
    let left: Vec<_> = std::fs::read_dir(scratch).expect("it").flatten().collect();
    assert!(left.is_empty(), "left behind: {left:?}");
    let text = text.concat();
    (output, text)
}

fn named<'a>(all: &'a Json, key: &str, name: &str) -> Option<&'a Json> {
    let mut all = all.as_array().expect("a list").iter();
    all.find(|one| one[key] == name)
}

/// The rows of a group: the first is ours, the others say what ours is in multiples of them.
fn check(group: &Json, ours: &str, rivals: &[&str]) {
    let rows = group["rows"].as_array().expect("rows");
    let names: Vec<_> = rows.iter().filter_map(|row| row["name"].as_str()).collect();
    assert_eq!(names, [&[ours], rivals].concat(), "{group}");
    for (number, row) in rows.iter().enumerate() {
        let counts = ["samples", "apart"].map(|key| row[key].as_u64().unwrap_or(0));
        assert!(counts[0] + counts[1] > 0, "{row}");
        assert!(row["p999"].is_null(), "{row}");
        assert_eq!(row["ours_is"].is_null(), number == 0, "{row}");
    }
}

#[test]
fn a_short_run_has_a_table_and_json_with_rivals_beside_ours() {
    let _turn = Turn::of_robots(3);
    let folder = tempfile::tempdir().expect("a folder");
    let only = ["--only", "wakeup,symbols,events,work"];
    let short = ["--seconds-per-part", "0.4"];
    let (output, text) = bench(folder.path(), &[only, short].concat());
    assert!(output.status.success(), "{text}");
    let json = std::fs::read_to_string(folder.path().join("out/bench.json")).expect("it");
    let json: Json = serde_json::from_str(&json).expect("JSON");
    assert_eq!(json["interrupted"], false);
    assert!(json["machine"]["cores"].as_u64() > Some(0) && json["stalls"]["count"].is_u64());
    let parts = &json["parts"];
    assert_eq!(parts.as_array().map(Vec::len), Some(4));
    for (part, groups) in [("wakeup", 2), ("symbols", 26), ("events", 1), ("work", 5)] {
        let own = named(parts, "part", part).unwrap_or_else(|| panic!("no {part}"));
        assert!(own["failure"].is_null(), "{own}");
        let found = own["groups"].as_array().map(Vec::len);
        assert!(found >= Some(groups), "{own}");
        for group in own["groups"].as_array().into_iter().flatten() {
            let title = group["title"].as_str().expect("a title");
            assert!(text.contains(title), "{title} is missing: {text}");
            match part {
                "wakeup" => {
                    let notes = own["notes"].to_string();
                    let rival = "cyclictest";
                    let missing = notes.contains("cyclictest is left out");
                    let rivals = if missing { &[][..] } else { &[rival][..] };
                    check(group, "onboard", rivals);
                }
                "symbols" => check(group, "symbol table", &["Mutex", "RwLock", "arc-swap"]),
                "work" => check(group, "onboard", &[]),
                _ => check(group, "onboard", &["std::sync::mpsc"]),
            }
        }
    }
}

#[test]
fn buses_tubes_robots_and_mediators_are_measured_too() {
    once_more_if_late(|| {
        let _turn = Turn::of_robots(3);
        let folder = tempfile::tempdir().expect("a folder");
        let only = ["--only", "bus,tubes,robot,mediator"];
        let short = ["--seconds-per-part", "0.4"];
        let (output, text) = bench(folder.path(), &[only, short].concat());
        assert!(output.status.success(), "{text}");
        let json = std::fs::read_to_string(folder.path().join("out/bench.json")).expect("it");
        let json: Json = serde_json::from_str(&json).expect("JSON");
        let groups = |part: &str| {
            let own = named(&json["parts"], "part", part).unwrap_or_else(|| panic!("no {part}"));
            assert!(own["failure"].is_null(), "{own}");
            let groups = own["groups"].as_array().cloned().unwrap_or_default();
            (groups, own["notes"].to_string())
        };
        let (bus, notes) = groups("bus");
        let missing = notes.contains("SOEM is left out");
        let soem = ["SOEM, called from Python"];
        check(
            &bus[0],
            "drivers::ethercat",
            if missing { &[] } else { &soem },
        );
        let (tubes, _) = groups("tubes");
        check(&tubes[0], "tubes", &["brute force"]);
        let (robot, notes) = groups("robot");
        assert!(notes.contains("the robot's memory is"), "{notes}");
        let units: Vec<_> = robot.iter().map(|group| &group["unit"]).collect();
        assert_eq!(units, ["s", "ms", "MiB", "% of a core"]);
        robot.iter().for_each(|group| check(group, "onboard", &[]));
        let (mediator, _) = groups("mediator");
        assert_eq!(mediator.len(), 2);
        mediator
            .iter()
            .for_each(|group| check(group, "mediator", &[]));
    });
}

#[test]
fn a_part_that_there_is_not_is_refused_with_those_that_there_are() {
    let folder = tempfile::tempdir().expect("a folder");
    let (output, text) = bench(folder.path(), &["--only", "wheels"]);
    assert_eq!(output.status.code(), Some(2), "{text}");
    assert!(
        text.contains("wakeup") && text.contains("symbols"),
        "{text}"
    );
    assert!(!folder.path().join("out").exists());
}
