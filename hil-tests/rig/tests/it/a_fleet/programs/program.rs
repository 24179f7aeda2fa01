//! The rig as a program.

use std::fs::{self, File};
use std::path::Path;
use std::process::{Child, Command, ExitStatus, Stdio};
use std::time::{Duration, Instant};

use rustix::process::{Pid, Signal, kill_process, test_kill_process};
use serde_json::Value as Json;
use tempfile::TempDir;

use crate::programs::bench::{GUARDS, folder};
use crate::programs::fleet::{CONFIG, RIG};
use crate::programs::late::{note_violations, once_more_if_late};
use crate::programs::turn::Turn;

/// By now all robots, which start up to 3 s after each other, have been on their way for a while.
const UNDER_WAY: Duration = Duration::from_secs(8);

/// A rig under way, with a folder of its own for all temporary files.
struct Program {
    child: Child,
    folder: TempDir,
    _turn: Turn,
}

impl Program {
    /// Starts it as a user would in the repository's root.
    fn start(command: &[&str], robots: usize) -> Self {
        let turn = Turn::of_robots(robots);
        let folder = folder();
        let log = File::create(folder.path().join("rig.log")).expect("created");
        let child = Command::new(RIG)
            .current_dir(Path::new(CONFIG).join(".."))
            .args(command)
            .args(["--headless", "--seed", "5", "--out"])
            .arg(folder.path().join("out"))
            .env("TMPDIR", folder.path())
            .envs(GUARDS.map(|guard| (guard, "1")))
            .stdin(Stdio::null())
            .stdout(log.try_clone().expect("cloned"))
            .stderr(log)
            .spawn()
            .expect("the program starts");
        Self {
            child,
            folder,
            _turn: turn,
        }
    }

    fn signal(&self, signal: Signal) {
        let rig = i32::try_from(self.child.id()).ok().and_then(Pid::from_raw);
        kill_process(rig.expect("a process id"), signal).expect("it runs");
    }

    fn ended(&mut self, patience: Duration) -> ExitStatus {
        let began = Instant::now();
        loop {
            if let Some(status) = self.child.try_wait().expect("a child") {
                return status;
            }
            assert!(began.elapsed() < patience, "it ends: {}", self.said());
            std::thread::sleep(Duration::from_millis(20));
        }
    }

    /// The mediator and all robots, which are its children.
    fn children(&self) -> Vec<Pid> {
        let id = self.child.id();
        let tasks = { fs::read_dir(format!("/proc/{id}/task")).into_iter() }.flatten();
        tasks
            .flatten()
            .filter_map(|task| fs::read_to_string(task.path().join("children")).ok())
            .flat_map(|children| {
                let numbers = children.split_whitespace();
                let pids = numbers.filter_map(|number| Pid::from_raw(number.parse().ok()?));
                pids.collect::<Vec<_>>()
            })
            .collect()
    }

    fn said(&self) -> String {
        fs::read_to_string(self.folder.path().join("rig.log")).unwrap_or_default()
    }

    /// What is in the folder of temporary files, without what is to be there.
    fn left(&self) -> Vec<String> {
        { fs::read_dir(self.folder.path()).into_iter() }
            .flatten()
            .flatten()
            .map(|entry| entry.file_name().to_string_lossy().into_owned())
            .filter(|name| name != "out" && name != "rig.log")
            .collect()
    }
}

impl Drop for Program {
    fn drop(&mut self) {
        // Ended already is as good.
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

/// A command of a scenario starts its programs, whose robots drive their devices, and ends them when it is told to.
fn runs_its_programs(command: &str, robots: usize) {
    once_more_if_late(|| {
        let mut program = Program::start(&[command], robots);
        std::thread::sleep(UNDER_WAY);
        program.signal(Signal::INT);
        let status = program.ended(Duration::from_secs(15));
        let said = program.said();
        let summary = fs::read_to_string(program.folder.path().join("out/summary.json"));
        let summary: Json = serde_json::from_str(&summary.expect("left")).expect("JSON");
        note_violations(&summary);
        assert_eq!(status.code(), Some(1), "{said}");
        assert!(said.contains("interrupted"), "{said}");
        assert!(!said.contains("VIOLATION"), "{said}");
        let own = summary["robots"].as_array().expect("a list");
        assert_eq!(own.len(), robots);
        let stalls = &summary["stalls"];
        assert!(
            stalls["count"].is_u64() && stalls["longest_ms"].is_f64(),
            "{stalls}"
        );
        for robot in own {
            let cycles = robot["ethercat"]["cycles"].as_u64();
            let scans = robot["lidar"]["scans"].as_u64();
            assert!(cycles > Some(1000) && scans > Some(5), "{robot}");
        }
        assert_eq!(program.left(), Vec::<String>::new());
    });
}

#[test]
fn overtaking_runs_its_programs() {
    runs_its_programs("overtaking", 2);
}

#[test]
fn docking_runs_its_programs() {
    runs_its_programs("docking", 3);
}

#[test]
fn the_t_junction_runs_its_programs() {
    runs_its_programs("t-junction", 3);
}

#[test]
fn the_course_runs_its_programs() {
    runs_its_programs("course", 1);
}

#[test]
fn the_clutter_runs_its_programs() {
    runs_its_programs("clutter", 1);
}

#[test]
fn killed_it_takes_mediator_and_robots_with_it() {
    once_more_if_late(|| {
        let mut program = Program::start(&["scenario", "config/scenarios/overtaking.toml"], 2);
        let began = Instant::now();
        let mut children = program.children();
        while children.len() < 3 {
            assert!(
                began.elapsed() < Duration::from_secs(15),
                "{}",
                program.said()
            );
            std::thread::sleep(Duration::from_millis(20));
            children = program.children();
        }
        std::thread::sleep(Duration::from_secs(3));
        program.signal(Signal::KILL);
        program.ended(Duration::from_secs(5));
        let began = Instant::now();
        while children
            .iter()
            .any(|&child| test_kill_process(child).is_ok())
        {
            assert!(
                began.elapsed() < Duration::from_secs(10),
                "{}",
                program.said()
            );
            std::thread::sleep(Duration::from_millis(20));
        }
        while !program.left().is_empty() {
            assert!(
                began.elapsed() < Duration::from_secs(15),
                "{:?}",
                program.left()
            );
            std::thread::sleep(Duration::from_millis(20));
        }
    });
}
