//! The stage of a scenario with the real programs: world, devices, listener, and the robot as a process.

use std::path::{Path, PathBuf};
use std::process::ExitStatus;

use config::{RobotConfig, SiteConfig};
use onboard::process::inspect;
use onboard::process::runtime::Runtime;
use serde_json::Value as Json;
use sim::rt::monotonic_ns;
use sim::world::{SharedWorld, Truth, World, WorldError};

use crate::cli::Failure;
use crate::folder::Folder;
use crate::one_robot::listener::Listener;
use crate::one_robot::summary::{EthercatSummary, LidarSummary, RobotSummary, round};
use crate::process::Usage;
use crate::process::robot::{RobotProcess, RobotSetup};
use crate::testbed::{BusPlace, Devices, drawn_start, start_pose, world};

/// What a scenario is set up with.
#[derive(Clone, Debug)]
pub struct StageSetup<'a> {
    /// Robot file.
    pub robot_file: &'a Path,
    /// Site file.
    pub site_file: &'a Path,
    /// Values changed in both, `KEY=VALUE`.
    pub set: &'a [String],
    /// Decides wheel errors, start offset and noise.
    pub seed: u64,
    /// Folder for what the scenario leaves.
    pub out: &'a Path,
}

/// A scenario under way. Fields are dropped in this order: the robot first, then its devices.
pub struct Stage {
    /// The robot.
    pub process: RobotProcess,
    /// Its devices.
    pub devices: Devices,
    /// The world.
    pub world: SharedWorld,
    /// An independent ear on the network.
    pub listener: Listener,
    /// What the robot file says.
    pub robot: RobotConfig,
    /// What the site file says.
    pub site: SiteConfig,
    /// Where the robot leaves its names.
    pub runtime: Runtime,
    /// When the robot was started.
    pub start_ns: u64,
    /// Memory and processor time of the robot.
    pub usage: Usage,
    seen: u64,
    _folder: Folder,
}

impl Stage {
    /// Builds the world, lets `furnish` put more into it, starts devices and robot.
    ///
    /// # Errors
    /// [`Failure::Refused`] naming what is wrong or cannot be had.
    pub fn set(
        setup: &StageSetup<'_>,
        furnish: impl FnOnce(&mut World) -> Result<(), WorldError>,
    ) -> Result<Self, Failure> {
        let report = |error| Failure::Refused(miette::Report::new(error));
        let overrides = onboard::cli::overrides(setup.set)?;
        let robot = config::load_robot(setup.robot_file, &overrides).map_err(report)?;
        let site = config::load_site(setup.site_file, &overrides).map_err(report)?;
        config::check_together(&robot, &site).map_err(report)?;
        make_folder(setup.out)?;
        let folder = Folder::new()?;
        let start = drawn_start(start_pose(&site, &robot.identity.id)?, setup.seed);
        let world = world(&site, &[(&robot, start)], setup.seed)?;
        furnish(&mut world.lock()).map_err(Failure::refused)?;
        let lidar_link = folder.path().join("lidar");
        let any_port = BusPlace::Udp(([127, 0, 0, 1], 0).into());
        let devices = Devices::start(
            &world,
            &robot,
            &any_port,
            Some(lidar_link.clone()),
            setup.seed,
        )?;
        // A name of this run's own, so that two rigs on one machine never meet.
        let key_prefix = format!("rig-{}", std::process::id());
        let listener = Listener::open(&key_prefix).map_err(Failure::refused)?;
        let runtime_folder = folder.path().join("run");
        let runtime = runtime_in(&runtime_folder)?;
        let mut set = setup.set.to_vec();
        let peers = [listener.endpoint()];
        set.extend(settings(&devices, &lidar_link, &peers, &key_prefix)?);
        let process = RobotProcess::start(RobotSetup {
            program: std::env::current_exe().map_err(Failure::refused)?,
            id: robot.identity.id.clone(),
            robot_file: setup.robot_file.to_owned(),
            site_file: setup.site_file.to_owned(),
            set,
            runtime: runtime_folder,
            log: setup.out.join("onboard.log"),
            environment: Vec::new(),
        })
        .map_err(|error| Failure::refused(format_args!("the robot cannot be started: {error}")))?;
        Ok(Self {
            usage: Usage::of(process.id()),
            process,
            devices,
            world,
            listener,
            robot,
            site,
            runtime,
            start_ns: monotonic_ns(),
            seen: 0,
            _folder: folder,
        })
    }

    /// What the world has logged of the robot since the last call.
    pub fn new_truths(&mut self) -> Vec<Truth> {
        let mut world = self.world.lock();
        world.advance_to(monotonic_ns());
        let truths = world
            .log()
            .since(self.seen)
            .map(|record| record.truth)
            .collect();
        self.seen = world.log().next_sequence();
        truths
    }

    /// All symbols of the running robot, as `onboard inspect --json` shows them.
    #[must_use]
    pub fn symbols(&self) -> Json {
        inspect::snapshot(&self.runtime, &self.robot.identity.id).unwrap_or(Json::Null)
    }

    /// Violations that the devices recorded, as kind and detail.
    #[must_use]
    pub fn device_violations(&self) -> Vec<(&'static str, String)> {
        device_violations(&self.robot, &self.devices)
    }

    /// A robot must end by itself and well when it is asked to.
    #[must_use]
    pub fn end_violation(status: ExitStatus) -> Option<(&'static str, String)> {
        (!status.success()).then(|| {
            (
                "robot-end",
                format!("the robot ended with {status}, expected success"),
            )
        })
    }

    /// Time since the robot was started.
    #[must_use]
    pub fn elapsed_s(&self) -> f64 {
        monotonic_ns().saturating_sub(self.start_ns) as f64 / 1e9
    }

    /// The robot's part of a summary, as far as all scenarios have it.
    #[must_use]
    pub fn robot_summary(&self, truth: Option<&Truth>, symbols: &Json) -> RobotSummary {
        robot_summary(&self.robot, &self.devices, &self.usage, truth, symbols)
    }
}

/// Makes a folder with all that leads there.
pub(crate) fn make_folder(folder: &Path) -> Result<(), Failure> {
    std::fs::create_dir_all(folder).map_err(|error| {
        Failure::refused(format_args!(
            "folder {} cannot be made: {error}",
            folder.display()
        ))
    })
}

/// Where robots leave their names.
pub(crate) fn runtime_in(folder: &Path) -> Result<Runtime, Failure> {
    Runtime::new(Some(folder.to_owned()))
        .map_err(|_| Failure::refused(format_args!("folder {} cannot be made", folder.display())))
}

/// What a robot is told to find its devices, and its fleet at these endpoints.
pub(crate) fn settings(
    devices: &Devices,
    lidar_link: &Path,
    peers: &[&str],
    key_prefix: &str,
) -> Result<[String; 5], Failure> {
    let bus =
        { devices.bus.local_addr() }.ok_or_else(|| Failure::refused("the bus has no address"))?;
    Ok([
        format!("ethercat.udp={:?}", bus.to_string()),
        format!("lidar.device={:?}", lidar_link.display().to_string()),
        format!("fleet.connect={peers:?}"),
        "fleet.scouting=false".to_owned(),
        format!("fleet.key_prefix={key_prefix:?}"),
    ])
}

/// Violations that the devices of a robot recorded, as kind and detail.
#[must_use]
pub fn device_violations(robot: &RobotConfig, devices: &Devices) -> Vec<(&'static str, String)> {
    let mut found = Vec::new();
    let statistics = devices.drive.statistics();
    let limit_rad_s = robot.drive.max_wheel_speed_rad_s;
    let largest_rad_s = largest_setpoint_rad_s(devices);
    if largest_rad_s > limit_rad_s + 1e-3 || statistics.not_finite > 0 {
        found.push((
            "setpoint",
            format!("a wheel setpoint of {largest_rad_s:.2} rad/s, expected at most {limit_rad_s}"),
        ));
    }
    let limit_a = robot.drive.drive_current_a;
    if statistics.max_current_a > limit_a + 1e-3 {
        found.push((
            "current",
            format!(
                "a current limit of {:.1} A, expected at most {limit_a}",
                statistics.max_current_a
            ),
        ));
    }
    found
}

fn largest_setpoint_rad_s(devices: &Devices) -> f64 {
    let statistics = devices.drive.statistics();
    let (left, right) = (&statistics.left_rad_s, &statistics.right_rad_s);
    left.magnitude().max(right.magnitude())
}

/// A robot's part of a summary, as far as all scenarios have it.
#[must_use]
pub fn robot_summary(
    robot: &RobotConfig,
    devices: &Devices,
    usage: &Usage,
    truth: Option<&Truth>,
    symbols: &Json,
) -> RobotSummary {
    let value = |datatype: &str| {
        let listed = symbols["symbols"].as_array().into_iter().flatten();
        listed
            .clone()
            .find(|symbol| symbol["datatype"] == datatype)
            .map_or(Json::Null, |symbol| symbol["value"].clone())
    };
    let (drive, lidar) = (value("drive_status"), value("lidar_status"));
    let count = |json: &Json, key: &str| json[key].as_u64().unwrap_or(0);
    RobotSummary {
        id: robot.identity.id.clone(),
        distance_m: round(truth.map_or(0.0, |truth| truth.distance_m)),
        collisions: truth.map_or(0, |truth| truth.collisions),
        min_clearance_m: round(truth.map_or(0.0, |truth| truth.min_clearance_m)),
        max_setpoint_rad_s: round(largest_setpoint_rad_s(devices)),
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
        rss_mib: round(usage.largest_rss_mib()),
        cpu_percent: round(usage.cpu_percent()),
        ..RobotSummary::default()
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

/// A flag that SIGINT and SIGTERM raise.
///
/// # Errors
/// [`Failure::Refused`] with the operating system's reason.
pub fn end_flag() -> Result<std::sync::Arc<std::sync::atomic::AtomicBool>, Failure> {
    let flag = std::sync::Arc::<std::sync::atomic::AtomicBool>::default();
    for signal in [signal_hook::consts::SIGINT, signal_hook::consts::SIGTERM] {
        signal_hook::flag::register(signal, std::sync::Arc::clone(&flag))
            .map_err(Failure::refused)?;
    }
    Ok(flag)
}

/// Writes a file of a scenario's folder.
///
/// # Errors
/// [`Failure::Failed`] when it cannot be written.
pub fn write(out: &Path, name: &str, text: &str) -> Result<PathBuf, Failure> {
    let file = out.join(name);
    std::fs::create_dir_all(out)
        .and_then(|()| std::fs::write(&file, text))
        .map_err(|error| {
            Failure::failed(format_args!(
                "{} cannot be written: {error}",
                file.display()
            ))
        })?;
    Ok(file)
}
