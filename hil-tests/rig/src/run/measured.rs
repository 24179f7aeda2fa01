//! What devices and a robot itself measured.

use config::RobotConfig;
use serde_json::Value as Json;
use sim::kelo::DriveStatistics;
use sim::world::Truth;

use crate::machine::round;
use crate::summary::{EthercatSummary, LidarSummary, RobotSummary};
use crate::violation::ViolationKind;

/// Violations that the devices of a robot recorded, as kind and detail.
pub(crate) fn device_violations(
    robot: &RobotConfig,
    statistics: &DriveStatistics,
) -> Vec<(ViolationKind, String)> {
    let mut found = Vec::new();
    let limit_rad_s = robot.drive.limits.max_wheel_speed_rad_s;
    let largest_rad_s = largest_setpoint_rad_s(statistics);
    if largest_rad_s > limit_rad_s + 1e-3 || statistics.not_finite > 0 {
        found.push((
            ViolationKind::Setpoint,
            format!("a wheel setpoint of {largest_rad_s:.2} rad/s, expected at most {limit_rad_s}"),
        ));
    }
    let limit_a = robot.drive.drive_current_a;
    if statistics.max_current_a > limit_a + 1e-3 {
        found.push((
            ViolationKind::Current,
            format!(
                "a current limit of {:.1} A, expected at most {limit_a}",
                statistics.max_current_a
            ),
        ));
    }
    found
}

fn largest_setpoint_rad_s(statistics: &DriveStatistics) -> f64 {
    let (left, right) = (&statistics.left_rad_s, &statistics.right_rad_s);
    left.magnitude().max(right.magnitude())
}

/// A robot's part of the summary. `symbols` is the last that `onboard inspect --json` showed.
pub(crate) fn robot_summary(
    robot: &RobotConfig,
    statistics: &DriveStatistics,
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
        max_setpoint_rad_s: round(largest_setpoint_rad_s(statistics)),
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
