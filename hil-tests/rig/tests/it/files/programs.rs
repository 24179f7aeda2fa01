//! The robot's files are wrong.

use std::fs;
use std::path::Path;
use std::process::{Command, Stdio};

use rig::process::robot::SUBCOMMAND;

use crate::programs::bench::{Bench, RIG, said, shipped};

#[test]
fn a_mistake_in_a_file_is_named_and_nothing_is_started() {
    let bench = Bench::new();
    let good = fs::read_to_string(bench.robot_file()).expect("readable");
    // What is changed, and words that must be in the message.
    let cases: [(&str, &str, &[&str]); 5] = [
        ("wheelbase_m = 0.25", "wheel_base = 0.25", &["wheel_base"]),
        (
            "wheelbase_m = 0.25",
            "wheelbase_m = \"short\"",
            &["wheelbase_m", "short"],
        ),
        (
            "wheelbase_m = 0.25",
            "wheelbase_m = nan",
            &["wheelbase_m", "nan"],
        ),
        (
            "wheelbase_m = 0.25",
            "wheelbase_m = -0.25",
            &["wheelbase_m", "-0.25"],
        ),
        ("priority = 80", "priority = 100", &["priority", "100"]),
    ];
    for (from, to, words) in cases {
        let text = good.replacen(from, to, 1);
        assert_ne!(text, good, "{from}");
        let file = bench.path("bad.toml");
        fs::write(&file, &text).expect("written");
        let line = text
            .lines()
            .position(|line| line.contains(to))
            .expect("there")
            + 1;
        let output = bench.run(&file);
        let message = said(&output);
        assert_eq!(output.status.code(), Some(2), "{to}: {message}");
        let place = format!("bad.toml:{line}");
        assert!(
            message.replace(' ', "").contains(&place),
            "{place}: {message}"
        );
        for word in words {
            assert!(message.contains(word), "{word}: {message}");
        }
        assert_eq!(bench.left_behind(), Vec::<String>::new(), "{to}");
    }
    let output = bench.run(Path::new("no-such-file.toml"));
    assert_eq!(output.status.code(), Some(2), "{}", said(&output));
    assert!(
        said(&output).contains("no-such-file.toml"),
        "{}",
        said(&output)
    );
    assert_eq!(
        bench.devices.drive.statistics().setpoints,
        0,
        "nothing spoke to the drive"
    );
    assert!(
        !bench.devices.lidar.counters().streaming,
        "nor to the lidar"
    );
}

fn check() -> Command {
    let [robot, site] = ["robots/amr-1.toml", "sites/corridor.toml"].map(shipped);
    let mut command = Command::new(RIG);
    command
        .arg(SUBCOMMAND)
        .args(["check", "--robot"])
        .arg(robot);
    command.arg("--site").arg(site);
    command
}

#[test]
fn check_prints_how_late_a_stop_may_begin() {
    let output = check().output().expect("it runs");
    assert!(output.status.success(), "{}", said(&output));
    let text = String::from_utf8_lossy(&output.stdout);
    for line in [
        "planned by the tubes",
        "the drive or its bus hangs",
        "wheels do not obey",
    ] {
        assert!(text.contains(line), "{line}: {text}");
    }
}

/// As with `onboard check ... | head -1`.
#[test]
fn who_closes_the_pipe_early_has_read_enough() {
    let mut command = check();
    command.stdout(Stdio::piped()).stderr(Stdio::piped());
    let mut child = command.spawn().expect("it starts");
    drop(child.stdout.take());
    let output = child.wait_with_output().expect("our child");
    assert!(output.status.success(), "{}", said(&output));
    assert!(output.stderr.is_empty(), "{}", said(&output));
}
