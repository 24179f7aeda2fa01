//! `rig lap`: one robot drives laps of a corridor.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::ExitStatus;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use config::{RobotConfig, SiteConfig};
use onboard::inspect;
use onboard::runtime::Runtime;
use serde_json::Value as Json;
use sim::rt::monotonic_ns;
use sim::world::{Pose, Random, SharedWorld, Truth};

use crate::cli::{Failure, LapArgs};
use crate::judge::Judge;
use crate::listener::Listener;
use crate::process_usage::Usage;
use crate::progress::Progress;
use crate::report;
use crate::robot::{RobotProcess, RobotSetup};
use crate::summary::{EthercatSummary, LidarSummary, Machine, RobotSummary, Summary};
use crate::testbed::{BusPlace, Devices, start_pose, world};

/// How often the judge looks at the world's log.
const LOOK: Duration = Duration::from_millis(20);
/// Longest time that one lap may take, and that the first motion may take on top.
const LAP_PATIENCE: Duration = Duration::from_secs(150);
/// Offset of the true start from the one in the file, drawn from the seed.
const START_OFFSET_M: f64 = 0.05;
const START_OFFSET_RAD: f64 = 0.05;
/// Numbers drawn for the start have nothing to do with those that the world draws.
const START_STREAM: u64 = 0x5354_4152;

/// Runs the scenario.
///
/// # Errors
/// [`Failure::Refused`] when nothing was started, [`Failure::Failed`] when laps are missing or something was violated.
pub fn lap(arguments: &LapArgs) -> Result<(), Failure> {
    let asked_to_end = Arc::<AtomicBool>::default();
    for signal in [signal_hook::consts::SIGINT, signal_hook::consts::SIGTERM] {
        signal_hook::flag::register(signal, Arc::clone(&asked_to_end)).map_err(Failure::refused)?;
    }
    let mut scenario = Scenario::prepare(arguments)?;
    println!(
        "lap: robot {} in {}, seed {}, {} laps; log in {}",
        scenario.robot.identity.id,
        scenario.site.name,
        arguments.seed,
        arguments.laps,
        scenario.process.setup().log.display()
    );
    let outcome = scenario.drive(arguments, &asked_to_end);
    scenario.finish(arguments, outcome)
}

/// How a run ended.
#[derive(Clone, Debug, PartialEq)]
enum Outcome {
    Done,
    Interrupted,
    TooSlow,
    RobotEnded(ExitStatus),
}

/// A run under way. Fields are dropped in this order: the robot first, then its devices.
struct Scenario {
    process: RobotProcess,
    devices: Devices,
    world: SharedWorld,
    listener: Listener,
    judge: Judge,
    robot: RobotConfig,
    site: SiteConfig,
    runtime: Runtime,
    start_ns: u64,
    path: Vec<Truth>,
    seen: u64,
    usage: Usage,
    _folder: Folder,
}

/// A folder of this run's own, removed with it.
struct Folder(PathBuf);

impl Drop for Folder {
    fn drop(&mut self) {
        // What cannot be removed is no reason to fail.
        let _ = fs::remove_dir_all(&self.0);
    }
}

impl Scenario {
    fn prepare(arguments: &LapArgs) -> Result<Self, Failure> {
        let report = |error| Failure::Refused(miette::Report::new(error));
        let robot = config::load_robot(&arguments.robot, &[]).map_err(report)?;
        let site = config::load_site(&arguments.site, &[]).map_err(report)?;
        config::check_together(&robot, &site).map_err(report)?;
        fs::create_dir_all(&arguments.out).map_err(|error| {
            Failure::refused(format_args!(
                "folder {} cannot be made: {error}",
                arguments.out.display()
            ))
        })?;
        let folder = Folder(run_folder()?);
        let start = drawn_start(start_pose(&site, &robot.identity.id)?, arguments.seed);
        let world = world(&site, &[(&robot, start)], arguments.seed)?;
        let lidar_link = folder.0.join("lidar");
        let any_port = BusPlace::Udp(([127, 0, 0, 1], 0).into());
        let devices = Devices::start(
            &world,
            &robot,
            &any_port,
            Some(lidar_link.clone()),
            arguments.seed,
        )?;
        let bus = devices
            .bus
            .local_addr()
            .ok_or_else(|| Failure::refused("the bus has no address"))?;
        // A name of this run's own, so that two rigs on one machine never meet.
        let key_prefix = format!("rig-{}", std::process::id());
        let listener = Listener::open(&key_prefix).map_err(Failure::refused)?;
        let runtime_folder = folder.0.join("run");
        let runtime = Runtime::new(Some(runtime_folder.clone())).map_err(|_| {
            Failure::refused(format_args!(
                "folder {} cannot be made",
                runtime_folder.display()
            ))
        })?;
        let process = RobotProcess::start(RobotSetup {
            program: std::env::current_exe().map_err(Failure::refused)?,
            id: robot.identity.id.clone(),
            robot_file: arguments.robot.clone(),
            site_file: arguments.site.clone(),
            set: vec![
                format!("ethercat.udp={:?}", bus.to_string()),
                format!("lidar.device={:?}", lidar_link.display().to_string()),
                format!("fleet.connect=[{:?}]", listener.endpoint()),
                "fleet.scouting=false".to_owned(),
                format!("fleet.key_prefix={key_prefix:?}"),
            ],
            runtime: runtime_folder,
            log: arguments.out.join("onboard.log"),
            environment: Vec::new(),
        })
        .map_err(|error| Failure::refused(format_args!("the robot cannot be started: {error}")))?;
        let start_ns = monotonic_ns();
        let judge = Judge::new(&robot.identity.id, &site, start_ns);
        Ok(Self {
            usage: Usage::of(process.id()),
            process,
            devices,
            world,
            listener,
            judge,
            robot,
            site,
            runtime,
            start_ns,
            path: Vec::new(),
            seen: 0,
            _folder: folder,
        })
    }

    fn drive(&mut self, arguments: &LapArgs, asked_to_end: &AtomicBool) -> Outcome {
        let mut progress = Progress::new(arguments.headless);
        let began = Instant::now();
        let patience = LAP_PATIENCE * (arguments.laps + 1);
        let outcome = loop {
            std::thread::sleep(LOOK);
            self.look();
            if let Some(truth) = self.path.last() {
                let heard = self.listener.heard(&self.robot.identity.id);
                let state = heard.as_ref().map(|heard| &heard.state);
                progress.show(self.judge.laps(), arguments.laps, state, truth);
            }
            self.usage.look();
            if let Some(status) = self.process.poll() {
                break Outcome::RobotEnded(status);
            }
            if asked_to_end.load(Ordering::Relaxed) {
                break Outcome::Interrupted;
            }
            if self.judge.laps() >= arguments.laps {
                break Outcome::Done;
            }
            if began.elapsed() > patience {
                break Outcome::TooSlow;
            }
        };
        progress.end();
        outcome
    }

    /// Takes in what the world has logged since the last look.
    fn look(&mut self) {
        let mut world = self.world.lock();
        world.advance_to(monotonic_ns());
        for record in world.log().since(self.seen) {
            self.judge.observe(&record.truth);
            self.path.push(record.truth);
        }
        self.seen = world.log().next_sequence();
    }

    fn finish(mut self, arguments: &LapArgs, outcome: Outcome) -> Result<(), Failure> {
        let id = self.robot.identity.id.clone();
        // Before it ends: afterwards there is nothing to look into.
        let symbols = inspect::snapshot(&self.runtime, &id).unwrap_or(Json::Null);
        let status = self.process.stop();
        self.look();
        self.check_devices();
        self.check_end(&outcome, status);
        let summary = self.summary(arguments, &outcome, &symbols);
        let write = |name: &str, text: &str| {
            let file = arguments.out.join(name);
            fs::write(&file, text).map_err(|error| {
                Failure::failed(format_args!(
                    "{} cannot be written: {error}",
                    file.display()
                ))
            })
        };
        let json = serde_json::to_string_pretty(&summary).map_err(Failure::failed)?;
        write("summary.json", &json)?;
        let svg = report::svg(
            &self.site,
            &self.robot,
            &self.path,
            &self.listener.changes(),
            &summary,
        );
        write("report.svg", &svg)?;
        print_figures(&summary, &arguments.out);
        if outcome == Outcome::Done && summary.violations.is_empty() {
            return Ok(());
        }
        let log = self.process.log_tail(12);
        Err(Failure::failed(format_args!(
            "{}; {} violations; the robot's last words:\n{log}",
            summary.outcome,
            summary.violations.len()
        )))
    }

    /// Violations that the devices recorded.
    fn check_devices(&mut self) {
        let statistics = self.devices.drive.statistics();
        let at_s = monotonic_ns().saturating_sub(self.start_ns) as f64 / 1e9;
        let limit_rad_s = self.robot.drive.max_wheel_speed_rad_s;
        let largest_rad_s = statistics
            .left_rad_s
            .magnitude()
            .max(statistics.right_rad_s.magnitude());
        if largest_rad_s > limit_rad_s + 1e-3 || statistics.not_finite > 0 {
            let detail = format!(
                "a wheel setpoint of {largest_rad_s:.2} rad/s, expected at most {limit_rad_s}"
            );
            self.judge.report("setpoint", at_s, detail);
        }
        let limit_a = self.robot.drive.drive_current_a;
        if statistics.max_current_a > limit_a + 1e-3 {
            let detail = format!(
                "a current limit of {:.1} A, expected at most {limit_a}",
                statistics.max_current_a
            );
            self.judge.report("current", at_s, detail);
        }
    }

    /// A robot must end by itself and well when it is asked to.
    fn check_end(&mut self, outcome: &Outcome, status: ExitStatus) {
        if !matches!(outcome, Outcome::RobotEnded(_)) && !status.success() {
            let at_s = monotonic_ns().saturating_sub(self.start_ns) as f64 / 1e9;
            self.judge.report(
                "robot-end",
                at_s,
                format!("the robot ended with {status}, expected success"),
            );
        }
    }

    fn summary(&self, arguments: &LapArgs, outcome: &Outcome, symbols: &Json) -> Summary {
        let value = |datatype: &str| {
            let listed = symbols["symbols"].as_array().into_iter().flatten();
            listed
                .clone()
                .find(|symbol| symbol["datatype"] == datatype)
                .map_or(Json::Null, |symbol| symbol["value"].clone())
        };
        let (drive, lidar) = (value("drive_status"), value("lidar_status"));
        let count = |json: &Json, key: &str| json[key].as_u64().unwrap_or(0);
        let truth = self.path.last();
        let statistics = self.devices.drive.statistics();
        let robot = RobotSummary {
            id: self.robot.identity.id.clone(),
            laps: self.judge.laps(),
            distance_m: round(truth.map_or(0.0, |truth| truth.distance_m)),
            collisions: truth.map_or(0, |truth| truth.collisions),
            min_clearance_m: round(truth.map_or(0.0, |truth| truth.min_clearance_m)),
            max_lateral_error_m: round(self.judge.max_lateral_error_m),
            max_speed_m_s: round(self.judge.max_speed_m_s),
            max_setpoint_rad_s: round(
                statistics
                    .left_rad_s
                    .magnitude()
                    .max(statistics.right_rad_s.magnitude()),
            ),
            threads: threads(symbols),
            ethercat: EthercatSummary {
                cycles: count(&drive, "cycles"),
                lost_frames: count(&drive, "lost_frames"),
                wkc_errors: count(&drive, "wkc_errors"),
            },
            lidar: LidarSummary {
                scans: count(&lidar, "scans"),
                dropped: count(&lidar, "dropped"),
            },
            rss_mib: round(self.usage.largest_rss_mib()),
            cpu_percent: round(self.usage.cpu_percent()),
        };
        Summary {
            scenario: "lap".to_owned(),
            outcome: match outcome {
                Outcome::Done => "done".to_owned(),
                Outcome::Interrupted => "interrupted".to_owned(),
                Outcome::TooSlow => {
                    format!("only {} of {} laps in time", robot.laps, arguments.laps)
                }
                Outcome::RobotEnded(status) => format!("the robot ended by itself with {status}"),
            },
            seed: arguments.seed,
            duration_s: round(monotonic_ns().saturating_sub(self.start_ns) as f64 / 1e9),
            machine: Machine::here(),
            robots: vec![robot],
            violations: self.judge.violations.clone(),
        }
    }
}

/// Each thread's timing, by its name, as the robot measured it itself.
fn threads(symbols: &Json) -> Json {
    let listed = symbols["symbols"].as_array().into_iter().flatten();
    let threads = listed
        .filter(|symbol| symbol["datatype"] == "thread_report")
        .map(|symbol| {
            let value = &symbol["value"];
            let entry = serde_json::json!({
                "period_us": value["period_ns"].as_u64().unwrap_or(0) / 1000,
                "wakeup_us": value["wakeup"],
                "exec_us": value["exec"],
                "overruns": value["overruns"],
                "cycles": value["cycles"],
                "granted": value["granted"],
            });
            (symbol["model"].as_str().unwrap_or("?").to_owned(), entry)
        });
    Json::Object(threads.collect())
}

/// Metres and the like to a tenth of a millimetre: more digits say nothing.
fn round(value: f64) -> f64 {
    (value * 1e4).round() / 1e4
}

/// The start in the file, with an offset that the robot does not know of.
fn drawn_start(start: Pose, seed: u64) -> Pose {
    let mut random = Random::new(seed, START_STREAM);
    let mut draw = |most: f64| random.symmetric(most);
    Pose::new(
        start.x_m + draw(START_OFFSET_M),
        start.y_m + draw(START_OFFSET_M),
        start.theta_rad + draw(START_OFFSET_RAD),
    )
}

/// A fresh folder for what must not be seen by other runs.
fn run_folder() -> Result<PathBuf, Failure> {
    let folder = std::env::temp_dir().join(format!(
        "rig-{}-{}",
        std::process::id(),
        monotonic_ns() % 1_000_000
    ));
    fs::create_dir_all(&folder).map_err(|error| {
        Failure::refused(format_args!(
            "folder {} cannot be made: {error}",
            folder.display()
        ))
    })?;
    Ok(folder)
}

fn print_figures(summary: &Summary, out: &Path) {
    println!(
        "outcome: {} after {:.1} s",
        summary.outcome, summary.duration_s
    );
    for robot in &summary.robots {
        println!(
            "{}: {} laps, {:.2} m, {} collisions, clearance at least {:.3} m, lateral error at most {:.3} m",
            robot.id,
            robot.laps,
            robot.distance_m,
            robot.collisions,
            robot.min_clearance_m,
            robot.max_lateral_error_m
        );
        println!(
            "  {:.1} MiB resident, {:.1} % of one core ({}, {} cores)",
            robot.rss_mib, robot.cpu_percent, summary.machine.processor, summary.machine.cores
        );
        println!(
            "  EtherCAT: {} cycles, {} lost, {} wrong counters; lidar: {} scans, {} dropped",
            robot.ethercat.cycles,
            robot.ethercat.lost_frames,
            robot.ethercat.wkc_errors,
            robot.lidar.scans,
            robot.lidar.dropped
        );
        for (name, thread) in robot.threads.as_object().into_iter().flatten() {
            let of = |what: &str, part: &str| thread[what][part].as_f64().unwrap_or(0.0);
            println!(
                "  {name:<14} wake-up p50 {:>6.0} p99 {:>6.0} max {:>7.0} µs; execution p50 {:>5.0} p99 {:>6.0} max {:>7.0} µs; {} overruns of {}",
                of("wakeup_us", "p50"),
                of("wakeup_us", "p99"),
                of("wakeup_us", "max"),
                of("exec_us", "p50"),
                of("exec_us", "p99"),
                of("exec_us", "max"),
                thread["overruns"],
                thread["cycles"]
            );
        }
    }
    for violation in &summary.violations {
        println!(
            "VIOLATION {} at {:.1} s: {}",
            violation.kind, violation.at_s, violation.detail
        );
    }
    println!(
        "wrote {} and report.svg",
        out.join("summary.json").display()
    );
}
