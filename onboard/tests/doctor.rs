//! `onboard doctor` and what `onboard run` refuses, through the program.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use rustix::pty::{OpenptFlags, grantpt, openpt, ptsname, unlockpt};

const FILES: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../config");

/// The shipped robot, with its frames on this interface.
fn on_interface(folder: &Path, interface: &str) -> PathBuf {
    let text = fs::read_to_string(format!("{FILES}/robots/amr-1.toml")).expect("it is shipped");
    let link = |line: &str| line.starts_with("udp = ");
    assert_eq!(text.lines().filter(|line| link(line)).count(), 1);
    let own = format!("interface = \"{interface}\"");
    let lines: Vec<&str> = { text.lines() }
        .map(|line| if link(line) { own.as_str() } else { line })
        .collect();
    let path = folder.join("robot.toml");
    fs::write(&path, lines.join("\n")).expect("written");
    path
}

fn folder() -> tempfile::TempDir {
    use std::os::unix::fs::PermissionsExt;
    tempfile::Builder::new()
        .permissions(fs::Permissions::from_mode(0o700))
        .tempdir()
        .expect("a folder")
}

fn onboard(
    mut program: Command,
    what: &str,
    robot: &Path,
    runtime: &Path,
    more: &[&str],
) -> Output {
    program
        .arg(what)
        .arg("--robot")
        .arg(robot)
        .args([
            "--site",
            &format!("{FILES}/sites/corridor.toml"),
            "--runtime",
        ])
        .arg(runtime)
        .args(more)
        .output()
        .expect("it ends")
}

fn itself() -> Command {
    Command::new(env!("CARGO_BIN_EXE_onboard"))
}

fn shipped() -> PathBuf {
    Path::new(FILES).join("robots/amr-1.toml")
}

#[test]
fn a_lidar_that_is_not_there_is_bad_with_what_should_be() {
    let runtime = folder();
    let found = onboard(
        itself(),
        "doctor",
        &shipped(),
        runtime.path(),
        &["--set", "lidar.device=\"/dev/no-such\""],
    );
    let text = String::from_utf8_lossy(&found.stdout);
    assert_eq!(found.status.code(), Some(1), "{text}");
    assert!(
        text.contains("bad   serial device        there is no /dev/no-such"),
        "{text}"
    );
    for subject in [
        "kernel",
        "PREEMPT_RT",
        "throttling",
        "autogroups",
        "real-time priority",
        "governor",
        "room on disk",
    ] {
        assert!(text.contains(subject), "{subject}: {text}");
    }
    // It sends no frames over UDP.
    assert!(!text.contains("raw frames"), "{text}");
    let said = String::from_utf8_lossy(&found.stderr);
    assert!(said.contains("that stop the robot"), "{said}");
}

#[test]
fn each_finding_is_an_object_for_programs() {
    let runtime = folder();
    let master = openpt(OpenptFlags::RDWR | OpenptFlags::NOCTTY).expect("a terminal");
    grantpt(&master).expect("granted");
    unlockpt(&master).expect("unlocked");
    let name = ptsname(&master, Vec::new()).expect("a name");
    let device = format!("lidar.device={name:?}");
    let found = onboard(
        itself(),
        "doctor",
        &shipped(),
        runtime.path(),
        &["--json", "--set", &device],
    );
    let text = String::from_utf8_lossy(&found.stdout);
    let findings: Vec<serde_json::Value> = { text.lines() }
        .map(|line| serde_json::from_str(line).expect("an object a line"))
        .collect();
    let verdict = |subject: &str| {
        let own = findings.iter().find(|own| own["subject"] == subject);
        own.map(|own| own["verdict"].as_str().expect("a word").to_owned())
    };
    assert_eq!(verdict("absolute sleep").as_deref(), Some("good"), "{text}");
    assert_eq!(verdict("serial device").as_deref(), Some("good"), "{text}");
    for own in &findings {
        let is_worse = matches!(own["verdict"].as_str(), Some("weak" | "bad"));
        assert!(
            own["should"].is_string() || own["verdict"] == "good",
            "{own}"
        );
        assert!(own["command"].is_string() || !is_worse, "{own}");
    }
}

#[test]
fn a_bus_that_is_not_there_is_bad() {
    let runtime = folder();
    let robot = on_interface(runtime.path(), "no-such-bus");
    let found = onboard(itself(), "doctor", &robot, runtime.path(), &[]);
    let text = String::from_utf8_lossy(&found.stdout);
    assert!(
        text.contains("bad   interface            there is no no-such-bus; there are "),
        "{text}"
    );
    assert!(text.contains("bad   raw frames"), "{text}");
}

#[test]
fn a_real_bus_is_not_driven_without_real_time_priority_unless_told() {
    let runtime = folder();
    let robot = on_interface(runtime.path(), "lo");
    let mut program = Command::new("setpriv");
    program.args(["--bounding-set=-sys_nice", env!("CARGO_BIN_EXE_onboard")]);
    let is_there = Command::new("setpriv").arg("--version").output().is_ok();
    if !is_there || !rustix::process::geteuid().is_root() {
        eprintln!("SKIPPED: takes root and setpriv");
        return;
    }
    let refused = onboard(program, "run", &robot, runtime.path(), &[]);
    let said = String::from_utf8_lossy(&refused.stderr);
    assert_eq!(refused.status.code(), Some(2), "{said}");
    // The message is folded to the terminal's width.
    let said = said.split_whitespace().collect::<Vec<_>>().join(" ");
    for part in [
        "without real-time priority",
        "CAP_SYS_NICE",
        "--without-real-time",
    ] {
        assert!(said.contains(part), "{part}: {said}");
    }
}

/// Also by somebody who may have it: the file does not ask for it.
#[test]
fn a_real_bus_is_not_driven_by_a_thread_of_normal_priority() {
    let runtime = folder();
    let robot = on_interface(runtime.path(), "lo");
    let text = fs::read_to_string(&robot).expect("written");
    let fieldbus = "scheduling = \"fifo\"\npriority = 80\n";
    assert!(text.contains(fieldbus), "the drive's thread");
    let text = text.replace(fieldbus, "scheduling = \"normal\"\n");
    fs::write(&robot, text).expect("written");
    let program = Command::new(env!("CARGO_BIN_EXE_onboard"));
    let refused = onboard(program, "run", &robot, runtime.path(), &[]);
    let said = String::from_utf8_lossy(&refused.stderr);
    let said = said.split_whitespace().collect::<Vec<_>>().join(" ");
    assert_eq!(refused.status.code(), Some(2), "{said}");
    // Without rights the other threads are refused, too.
    let expected = "threads.fieldbus.scheduling = \"normal\"";
    assert!(said.contains(expected), "{said}");
}
