//! A world, the devices of one robot, and the robot as a process.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};
use std::sync::atomic::{AtomicU32, Ordering};

use config::RobotConfig;
use contract::wire::RobotState;
use onboard::process::runtime::Runtime;
use rig::network::listener::Listener;
use rig::process::robot::{Program, RobotProcess, RobotSetup, SUBCOMMAND};
use rig::run::settings;
use rig::testbed::{BusPlace, Devices, start_pose, world};
use sim::world::{Pose, SharedWorld};
use tempfile::TempDir;

use crate::programs::figures::ThreadFigures;
use crate::programs::late;
use crate::programs::turn::Turn;

/// The program under test.
pub const RIG: &str = env!("CARGO_BIN_EXE_rig");
/// The robot of the files that ship.
pub const ROBOT: &str = "amr-1";
const SEED: u64 = 7;
const LOG_LINES: usize = 60;

/// A file that ships, by its path below `config`.
pub fn shipped(path: &str) -> PathBuf {
    Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../../config")).join(path)
}

/// Runs `onboard` as the rig does, until it ends.
pub fn onboard(arguments: &[&str]) -> Output {
    Command::new(RIG)
        .arg(SUBCOMMAND)
        .args(arguments)
        .stdin(Stdio::null())
        .output()
        .expect("the program starts")
}

/// A folder in memory, as a robot's own is in `/run`: nobody waits for a disk.
pub fn folder() -> TempDir {
    tempfile::tempdir_in("/dev/shm").expect("a temporary folder")
}

/// Set to 1, each ends a robot one of whose real-time threads breaks a rule.
pub const GUARDS: [&str; 2] = ["ONBOARD_ALLOC_GUARD", "ONBOARD_SYSTEM_CALL_GUARD"];

/// Both streams of an ended program on one line, so that a message is found however it was wrapped.
pub fn said(output: &Output) -> String {
    let text = [&output.stdout[..], &output.stderr[..]].concat();
    String::from_utf8_lossy(&text)
        .lines()
        .map(|line| line.trim_matches([' ', '│', '×', '╰', '─', '▶', '╭', '├']))
        .collect::<Vec<_>>()
        .join(" ")
}

/// Everything one test needs. Fields are dropped in this order: the robot first, then its devices.
pub struct Bench {
    /// The robot, once started.
    pub robot: Option<RobotProcess>,
    /// Its devices.
    pub devices: Devices,
    /// The world.
    pub world: SharedWorld,
    /// Its files as read here.
    pub config: RobotConfig,
    listener: Listener,
    key_prefix: String,
    starts: u32,
    /// More `--set` arguments for the next robot.
    pub more: Vec<String>,
    folder: TempDir,
    _turn: Turn,
}

impl Bench {
    /// World and devices, at the start pose of the site, with copies of the files that ship.
    pub fn new() -> Self {
        Self::in_turn(Turn::of_robots(1))
    }

    fn in_turn(turn: Turn) -> Self {
        static BENCHES: AtomicU32 = AtomicU32::new(0);
        let folder = folder();
        for (from, to) in [
            ("robots/amr-1.toml", "robot.toml"),
            ("sites/corridor.toml", "site.toml"),
        ] {
            fs::copy(shipped(from), folder.path().join(to)).expect("copied");
        }
        let config = config::load_robot(folder.path().join("robot.toml"), &[]).expect("good");
        let site = config::load_site(folder.path().join("site.toml"), &[]).expect("good");
        let start = start_pose(&site, ROBOT).expect("the site knows the robot");
        let world = world(&site, &[(&config, start)], SEED).expect("a world");
        let devices = Devices::start(
            &world,
            &config,
            &BusPlace::Udp(([127, 0, 0, 1], 0).into()),
            Some(folder.path().join("lidar")),
            SEED,
        )
        .expect("devices start");
        let number = BENCHES.fetch_add(1, Ordering::Relaxed);
        let key_prefix = format!("bad-days-{}-{number}", std::process::id());
        Self {
            robot: None,
            devices,
            world,
            config,
            listener: Listener::open(&key_prefix, &site, &[]).expect("the network opens"),
            key_prefix,
            starts: 0,
            more: Vec::new(),
            folder,
            _turn: turn,
        }
    }

    /// The same, with a robot that already drives.
    pub fn driving() -> Self {
        Self::new().drives()
    }

    /// The same, for a minute.
    pub fn driving_for_long() -> Self {
        Self::in_turn(Turn::of_robots_for_long(1)).drives()
    }

    /// The same, while no other test has a robot.
    pub fn driving_alone() -> Self {
        Self::in_turn(Turn::of_the_machine()).drives()
    }

    fn drives(mut self) -> Self {
        self.start();
        self.until_driving();
        self
    }

    /// Starts the robot with both guards armed; the one before it is handed back, not touched.
    pub fn start(&mut self) -> Option<RobotProcess> {
        self.starts += 1;
        let robot = RobotProcess::start(RobotSetup {
            program: Program::Rig(RIG.into()),
            id: ROBOT.to_owned(),
            robot_file: self.robot_file(),
            site_file: self.site_file(),
            set: self.set(),
            runtime: self.runtime_folder(),
            log: self.log_file(),
            environment: GUARDS
                .map(|guard| (guard.to_owned(), "1".to_owned()))
                .into(),
        })
        .expect("the robot starts");
        self.robot.replace(robot)
    }

    /// What leads the robot to its devices and to the listener.
    pub fn set(&self) -> Vec<String> {
        let peers = [self.listener.endpoint()];
        let set = settings(&self.devices, &self.path("lidar"), &peers, &self.key_prefix);
        let set = set.expect("over UDP").into_iter();
        set.chain(self.more.iter().cloned()).collect()
    }

    /// Address of the bus.
    pub fn bus_address(&self) -> String {
        self.devices.bus.local_addr().expect("over UDP").to_string()
    }

    /// A path in the test's own folder.
    pub fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    /// The test's own robot file.
    pub fn robot_file(&self) -> PathBuf {
        self.path("robot.toml")
    }

    /// The test's own site file.
    pub fn site_file(&self) -> PathBuf {
        self.path("site.toml")
    }

    /// Folder for the names of robots.
    pub fn runtime_folder(&self) -> PathBuf {
        self.path("run")
    }

    fn log_file(&self) -> PathBuf {
        self.path(&format!("onboard-{}.log", self.starts))
    }

    /// All that the last robot logged.
    pub fn log(&self) -> String {
        fs::read_to_string(self.log_file()).unwrap_or_default()
    }

    /// The running robot.
    pub fn process(&mut self) -> &mut RobotProcess {
        self.robot.as_mut().expect("it was started")
    }

    /// Runs the robot's program with this robot file until it ends, where the bench's robot runs.
    pub fn run(&self, robot_file: &Path) -> Output {
        self.command(robot_file).output().expect("it starts")
    }

    /// The same, not started yet.
    pub fn command(&self, robot_file: &Path) -> Command {
        let text = |path: &Path| path.display().to_string();
        let (robot, site) = (text(robot_file), text(&self.site_file()));
        let (runtime, set) = (text(&self.runtime_folder()), self.set());
        let mut arguments = vec!["run", "--robot", &robot, "--site", &site];
        arguments.extend(["--runtime", &runtime]);
        arguments.extend(set.iter().flat_map(|value| ["--set", value.as_str()]));
        let mut command = Command::new(RIG);
        command.arg(SUBCOMMAND).args(arguments).stdin(Stdio::null());
        command.envs(GUARDS.map(|guard| (guard, "1")));
        command
    }

    /// `onboard ctl REQUEST`, with the words that belong to it.
    pub fn ctl(&self, request: &str) -> Output {
        let runtime = self.runtime_folder();
        let runtime = runtime.to_str().expect("a plain path");
        let words = ["ctl"].into_iter().chain(request.split_whitespace());
        let arguments: Vec<&str> = words
            .chain(["--robot", ROBOT, "--runtime", runtime])
            .collect();
        onboard(&arguments)
    }

    /// `onboard ctl REQUEST`, which is to succeed.
    pub fn ask(&self, request: &str) {
        let output = self.ctl(request);
        assert!(output.status.success(), "ctl {request}: {}", said(&output));
    }

    /// `onboard ctl REQUEST`, which is to fail and to name the reason.
    pub fn is_refused(&self, request: &str, reason: &str) {
        let output = self.ctl(request);
        assert_eq!(output.status.code(), Some(1), "{}", said(&output));
        assert!(said(&output).contains(reason), "{}", said(&output));
    }

    /// How the robot's threads do.
    pub fn threads(&self) -> Vec<ThreadFigures> {
        ThreadFigures::of(&self.runtime(), ROBOT)
    }

    fn runtime(&self) -> Runtime {
        Runtime::new(Some(self.runtime_folder())).expect("the runtime folder")
    }

    /// What the robot published last.
    pub fn published(&self) -> RobotState {
        let observations = self.listener.observations();
        let said = observations.said(ROBOT);
        said.map(|said| said.state.clone()).unwrap_or_default()
    }

    /// Whether the robot publishes that this fault is present.
    pub fn publishes(&self, fault: &str) -> bool {
        let state = self.published();
        state
            .faults
            .iter()
            .any(|listed| listed.name == fault && listed.active)
    }

    /// How often the robot says that this fault was raised.
    pub fn raised(&self, fault: &str) -> u64 {
        let state = self.published();
        let listed = state.faults.iter().find(|listed| listed.name == fault);
        listed.map_or(0, |listed| listed.count)
    }

    /// Names in shared memory and in the runtime folder; folders without a file in them say nothing.
    pub fn left_behind(&self) -> Vec<String> {
        let runtime = self.runtime();
        let prefix = runtime.place().prefix;
        let shared = fs::read_dir("/dev/shm").into_iter().flatten().flatten();
        let mut names: Vec<String> = shared
            .map(|entry| format!("/dev/shm/{}", entry.file_name().to_string_lossy()))
            .filter(|name| name.contains(&prefix))
            .collect();
        files_below(runtime.folder(), &mut names);
        names
    }

    /// Where `base_link` is truly, with something at this place ahead and to the left of it.
    pub fn ahead(&self, forward_m: f64, left_m: f64) -> Pose {
        let pose = self.truth().pose;
        let (sin, cos) = pose.theta_rad.sin_cos();
        Pose::new(
            pose.x_m + cos * forward_m - sin * left_m,
            pose.y_m + sin * forward_m + cos * left_m,
            pose.theta_rad,
        )
    }

    /// The end of a good day: told to end, the robot stands, ends well and leaves nothing, but for a note if it waited for people; it
    /// never hit anything.
    pub fn finish(mut self) {
        let status = self.process().stop();
        assert!(status.success(), "the robot ended with {status}");
        let mut left = self.left_behind();
        left.retain(|path| !path.ends_with(".journey"));
        assert_eq!(left, Vec::<String>::new());
        let truth = self.truth();
        assert_eq!(truth.collisions, 0, "{truth:?}");
        assert!(truth.twist.v_m_s.abs() < 0.02, "{truth:?}");
        let log = self.log();
        assert!(
            log.contains("allocation guard armed, guard of system calls armed")
                && !log.contains("its system calls are not guarded"),
            "{log}"
        );
    }
}

impl Drop for Bench {
    fn drop(&mut self) {
        if std::thread::panicking() && self.starts > 0 {
            let log = self.log();
            late::note(&log);
            let lidar = self.devices.lidar.counters();
            late::note_missed_turns(lidar.missed_turns);
            if self.truth().collisions > 0 {
                late::note_unsafe();
            }
            let lines: Vec<&str> = log.lines().collect();
            let tail = &lines[lines.len().saturating_sub(LOG_LINES)..];
            eprintln!("truth: {:?}", self.truth());
            eprintln!("the lidar: {lidar:?}");
            eprintln!("the robot's log:\n{}", tail.join("\n"));
        }
    }
}

fn files_below(folder: &Path, names: &mut Vec<String>) {
    for entry in fs::read_dir(folder).into_iter().flatten().flatten() {
        let path = entry.path();
        if path.is_dir() {
            files_below(&path, names);
        } else {
            names.push(path.display().to_string());
        }
    }
}
