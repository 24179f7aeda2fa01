//! `summary.json`: what a scenario leaves for programs to read.

use serde::Serialize;
use serde_json::Value as Json;

use crate::judge::Figures;

/// The whole summary.
#[derive(Clone, Debug, Serialize)]
pub struct Summary {
    /// Name of the scenario.
    pub scenario: String,
    /// `done`, `interrupted`, or what went wrong.
    pub outcome: String,
    /// Decides wheel errors, start offset and noise.
    pub seed: u64,
    /// From the robot's start to its end.
    pub duration_s: f64,
    /// What it ran on, so that figures can be judged.
    pub machine: Machine,
    /// One entry for each robot.
    pub robots: Vec<RobotSummary>,
    /// What must not happen and did, from the world's truth and the devices' own records.
    pub violations: Vec<Violation>,
    /// What the judge of a trial found out.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub figures: Option<Figures>,
}

/// The machine that figures were measured on.
#[derive(Clone, Debug, Serialize)]
pub struct Machine {
    /// Processor, as the kernel names it.
    pub processor: String,
    /// Number of cores.
    pub cores: usize,
    /// Version of the kernel.
    pub kernel: String,
}

/// What happened to one robot.
#[derive(Clone, Debug, Default, Serialize)]
pub struct RobotSummary {
    /// Its identity.
    pub id: String,
    /// Laps by the world's truth.
    pub laps: u32,
    /// Way driven.
    pub distance_m: f64,
    /// Collisions.
    pub collisions: u64,
    /// Smallest distance of its footprint to anything.
    pub min_clearance_m: f64,
    /// Largest distance of `base_link` from the lane's centre in areas that are driven on a lane.
    pub max_lateral_error_m: f64,
    /// Fastest true speed.
    pub max_speed_m_s: f64,
    /// Largest wheel setpoint that its drive received.
    pub max_setpoint_rad_s: f64,
    /// Threads, with times in µs, as the robot measured them.
    pub threads: Json,
    /// Counters of the bus.
    pub ethercat: EthercatSummary,
    /// Counters of the lidar.
    pub lidar: LidarSummary,
    /// Resident memory of the robot's process.
    pub rss_mib: f64,
    /// Share of one core that the robot's process used.
    pub cpu_percent: f64,
}

/// Counters of the bus.
#[derive(Clone, Copy, Debug, Default, Serialize)]
pub struct EthercatSummary {
    /// Exchanges.
    pub cycles: u64,
    /// Frames without an answer in time.
    pub lost_frames: u64,
    /// Answers with a wrong working counter.
    pub wkc_errors: u64,
}

/// Counters of the lidar.
#[derive(Clone, Copy, Debug, Default, Serialize)]
pub struct LidarSummary {
    /// Good scans.
    pub scans: u64,
    /// Scans dropped as broken.
    pub dropped: u64,
}

/// Something that must not happen.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Violation {
    /// Kebab-case name.
    pub kind: String,
    /// Robot.
    pub robot: String,
    /// Seconds since the start.
    pub at_s: f64,
    /// What was found and what was expected.
    pub detail: String,
}

impl Machine {
    /// This machine.
    #[must_use]
    pub fn here() -> Self {
        let read = |path: &str| std::fs::read_to_string(path).unwrap_or_default();
        let processor = read("/proc/cpuinfo")
            .lines()
            .find_map(|line| {
                line.strip_prefix("model name")
                    .and_then(|rest| rest.split_once(':'))
            })
            .map_or_else(
                || std::env::consts::ARCH.to_owned(),
                |(_, name)| name.trim().to_owned(),
            );
        Self {
            processor,
            cores: std::thread::available_parallelism().map_or(1, Into::into),
            kernel: read("/proc/sys/kernel/osrelease").trim().to_owned(),
        }
    }
}

/// Metres and the like to a tenth of a millimetre: more digits say nothing.
#[must_use]
pub fn round(value: f64) -> f64 {
    (value * 1e4).round() / 1e4
}
