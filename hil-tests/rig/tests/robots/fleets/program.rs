//! The rig as a program.

use std::fs::{self, File};
use std::path::Path;
use std::process::{Child, Command, ExitStatus, Stdio};
use std::time::{Duration, Instant};

use rustix::process::{Pid, Signal, kill_process, test_kill_process};
use tempfile::TempDir;

use crate::fleets::bench::{CONFIG, RIG};
use crate::late::once_more_if_late;
use crate::turn::Turn;

/// A rig under way, with a folder of its own for all temporary files.
struct Program {
    child: Child,
    folder: TempDir,
    _turn: Turn,
}

impl Program {
    fn start(scenario: &str) -> Self {
        let turn = Turn::of_a_fleet();
        let folder = tempfile::tempdir().expect("a temporary folder");
        let log = File::create(folder.path().join("rig.log")).expect("created");
        let file = Path::new(CONFIG).join("scenarios").join(scenario);
        let child = Command::new(RIG)
            .arg("scenario")
            .arg(file.with_extension("toml"))
            .args(["--headless", "--rounds", "1", "--seed", "5", "--out"])
            .arg(folder.path().join("out"))
            .env("TMPDIR", folder.path())
            .env("ONBOARD_ALLOC_GUARD", "1")
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

#[test]
fn killed_it_takes_mediator_and_robots_with_it() {
    once_more_if_late(|| {
        let mut program = Program::start("overtaking");
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
        let rig = i32::try_from(program.child.id())
            .ok()
            .and_then(Pid::from_raw);
        kill_process(rig.expect("a process id"), Signal::KILL).expect("it runs");
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
