//! `rig course` through the real programs, once: every skill, with the allocation guard armed. Clutter runs stepped.

use std::process::Command;

use serde_json::Value as Json;

use crate::bad_days::bench::{RIG, shipped};
use crate::late::once_more_if_late;
use crate::turn::Turn;

/// Runs it and gives its summary.
fn trial(seed: u32) -> Json {
    let _turn = Turn::of_a_robot();
    let folder = tempfile::tempdir().expect("a temporary folder");
    let out = folder.path().join("out");
    let output = Command::new(RIG)
        .args(["course", "--headless", "--seed", &seed.to_string()])
        .arg("--robot")
        .arg(shipped("robots/amr-1.toml"))
        .arg("--site")
        .arg(shipped("sites/course.toml"))
        .arg("--out")
        .arg(&out)
        .env("TMPDIR", folder.path())
        .env("ONBOARD_ALLOC_GUARD", "1")
        .output()
        .expect("the program starts");
    let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
    assert!(
        output.status.success(),
        "{}\n{}",
        text(&output.stdout),
        text(&output.stderr)
    );
    for file in ["report.svg", "report.html"] {
        assert!(out.join(file).exists(), "{file} is missing");
    }
    let summary = std::fs::read_to_string(out.join("summary.json")).expect("a summary");
    serde_json::from_str(&summary).expect("JSON")
}

#[test]
fn a_robot_drives_the_course() {
    once_more_if_late(|| {
        let summary = trial(1);
        assert_eq!(summary["outcome"], "done");
        let docked = summary["robots"][0]["figures"]["dock_errors_m"].as_array();
        let docked = docked.and_then(|errors| errors.first()?.as_f64());
        assert!(
            docked.is_some_and(|error_m| error_m.abs() <= 0.02),
            "{summary}"
        );
    });
}
