//! `rig lap` is interrupted, or killed.

use std::fs::{self, File};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, ExitStatus, Stdio};
use std::time::{Duration, Instant};

use onboard::process::runtime::Runtime;
use rig::process::robot::SUBCOMMAND;
use rustix::process::{Pid, Signal, kill_process, test_kill_process};
use tempfile::TempDir;

use crate::programs::bench::{GUARDS, RIG, ROBOT, folder, shipped};
use crate::programs::late::once_more_if_late;
use crate::programs::turn::Turn;

/// After this time its robot is on its way.
const UNDER_WAY: Duration = Duration::from_secs(3);

/// A run under way, with a folder of its own for all temporary files.
struct Lap {
    child: Child,
    robot: Pid,
    socket: PathBuf,
    prefix: String,
    folder: TempDir,
    _turn: Turn,
}

impl Lap {
    /// Starts it and waits until its robot runs.
    fn start() -> Self {
        let turn = Turn::of_robots(1);
        let folder = folder();
        let log = File::create(folder.path().join("rig.log")).expect("created");
        let child = Command::new(RIG)
            .args(["lap", "--headless", "--laps", "1", "--robot"])
            .arg(shipped("robots/amr-1.toml"))
            .arg("--site")
            .arg(shipped("sites/corridor.toml"))
            .arg("--out")
            .arg(folder.path().join("out"))
            .env("TMPDIR", folder.path())
            .envs(GUARDS.map(|guard| (guard, "1")))
            .stdin(Stdio::null())
            .stdout(log.try_clone().expect("cloned"))
            .stderr(log)
            .spawn()
            .expect("the program starts");
        let mut lap = Self {
            robot: pid(child.id()),
            child,
            socket: PathBuf::new(),
            prefix: String::new(),
            folder,
            _turn: turn,
        };
        lap.wait("its robot runs", Duration::from_secs(10), |lap| {
            lap.find_robot()
        });
        lap
    }

    fn find_robot(&mut self) -> bool {
        let below = |folder: &Path| fs::read_dir(folder).into_iter().flatten().flatten();
        let socket = below(self.folder.path())
            .map(|entry| entry.path().join("run"))
            .map(|runtime| runtime.join(format!("{ROBOT}.ctl")))
            .find(|socket| socket.exists());
        let id = self.child.id();
        let children = fs::read_to_string(format!("/proc/{id}/task/{id}/children"));
        let robot = children
            .unwrap_or_default()
            .split_whitespace()
            .filter_map(|number| number.parse().ok())
            .find(|number| is_robot(*number));
        let (Some(socket), Some(robot)) = (socket, robot) else {
            return false;
        };
        let runtime = socket.parent().map(Path::to_path_buf);
        self.prefix = Runtime::new(runtime).expect("its folder").place().prefix;
        (self.socket, self.robot) = (socket, pid(robot));
        true
    }

    fn wait(&mut self, what: &str, patience: Duration, mut holds: impl FnMut(&mut Self) -> bool) {
        let began = Instant::now();
        while !holds(self) {
            assert!(began.elapsed() < patience, "{what}: {}", self.said());
            std::thread::sleep(Duration::from_millis(20));
        }
    }

    fn signal(&self, signal: Signal) {
        kill_process(pid(self.child.id()), signal).expect("it runs");
    }

    fn ended(&mut self) -> ExitStatus {
        let mut status = None;
        self.wait("it ends", Duration::from_secs(10), |lap| {
            status = lap.child.try_wait().expect("a child");
            status.is_some()
        });
        status.expect("waited for")
    }

    fn said(&self) -> String {
        fs::read_to_string(self.folder.path().join("rig.log")).unwrap_or_default()
    }

    /// Neither the robot's process nor its socket nor its shared memory is there.
    fn nothing_is_left(&mut self) {
        let robot = self.robot;
        self.wait("the robot ends", Duration::from_secs(8), |_| {
            test_kill_process(robot).is_err()
        });
        assert!(!self.socket.exists(), "{}", self.socket.display());
        let shared = fs::read_dir("/dev/shm").into_iter().flatten().flatten();
        let left: Vec<String> = shared
            .map(|entry| entry.file_name().to_string_lossy().into_owned())
            .filter(|name| name.contains(&self.prefix))
            .collect();
        assert_eq!(left, Vec::<String>::new());
    }
}

impl Drop for Lap {
    fn drop(&mut self) {
        // Ended already is as good.
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

/// Whether the process is a robot, and not the one that cleans up after the rig.
fn is_robot(number: u32) -> bool {
    let line = fs::read(format!("/proc/{number}/cmdline")).unwrap_or_default();
    line.split(|byte| *byte == 0)
        .any(|word| word == SUBCOMMAND.as_bytes())
}

fn pid(number: u32) -> Pid {
    let number = i32::try_from(number).ok();
    number.and_then(Pid::from_raw).expect("a process id")
}

#[test]
fn interrupted_it_stops_everything_and_says_so() {
    once_more_if_late(|| {
        let mut lap = Lap::start();
        std::thread::sleep(UNDER_WAY);
        lap.signal(Signal::INT);
        let status = lap.ended();
        assert_eq!(status.code(), Some(1), "{}", lap.said());
        assert!(lap.said().contains("interrupted"), "{}", lap.said());
        assert!(!lap.said().contains("VIOLATION"), "{}", lap.said());
        lap.nothing_is_left();
        let summary = fs::read_to_string(lap.folder.path().join("out/summary.json"));
        assert!(summary.is_ok_and(|text| text.contains("\"outcome\": \"interrupted\"")));
        let names = fs::read_dir(lap.folder.path())
            .into_iter()
            .flatten()
            .flatten();
        let mut left: Vec<_> = names.map(|entry| entry.file_name()).collect();
        left.sort();
        assert_eq!(left, ["out", "rig.log"], "temporary folders are removed");
    });
}

#[test]
fn killed_it_takes_its_robot_with_it() {
    once_more_if_late(|| {
        let mut lap = Lap::start();
        std::thread::sleep(UNDER_WAY);
        lap.signal(Signal::KILL);
        lap.ended();
        lap.nothing_is_left();
    });
}

#[test]
fn a_robot_that_dies_ends_the_run_and_leaves_nothing() {
    once_more_if_late(|| {
        let mut lap = Lap::start();
        std::thread::sleep(UNDER_WAY);
        kill_process(lap.robot, Signal::KILL).expect("it runs");
        let status = lap.ended();
        assert_eq!(status.code(), Some(1), "{}", lap.said());
        assert!(lap.said().contains("signal: 9"), "{}", lap.said());
        lap.nothing_is_left();
    });
}
