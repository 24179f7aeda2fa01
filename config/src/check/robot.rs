//! The numbers of a robot file against each other.

use std::time::Duration;

use crate::diagnostic::ProblemKind;
use crate::loaded::RobotConfig;
use crate::report::Report;
use description::endpoints::Endpoint;
use description::names::is_key_prefix;
use description::robot::{
    Fleet, Link, URG_04LX_HZ, URG_04LX_STEPS, check_mount, scan_bit_s, scan_bytes,
};
use description::threads::{ActivityKind, Trigger};

pub(super) fn check(robot: &RobotConfig, report: &Report) {
    drive(robot, report);
    ethercat(robot, report);
    lidar(robot, report);
    navigation(robot, report);
    tubes(robot, report);
    fleet(robot, report);
}

/// Reports the value of `key` when it does not fit, unless it was reported already.
fn refuse(bad: bool, report: &Report, key: &str, found: String, expected: String) {
    if bad && !report.touched(&[key]) {
        report.wrong(ProblemKind::Inconsistent, key, found, expected);
    }
}

fn drive(robot: &RobotConfig, report: &Report) {
    let d = &robot.drive;
    refuse(
        d.max_bus_voltage_v <= d.min_bus_voltage_v,
        report,
        "drive.max_bus_voltage_v",
        format!("{:?}", d.max_bus_voltage_v),
        format!("above `min_bus_voltage_v`, {} V", d.min_bus_voltage_v),
    );
    let planned_m_s2 = robot.navigation.deceleration_m_s2;
    refuse(
        planned_m_s2 > d.limits.deceleration_m_s2,
        report,
        "navigation.deceleration_m_s2",
        format!("{planned_m_s2:?}"),
        format!(
            "at most `drive.deceleration_m_s2`, {} m/s²: else the robot stands behind the borders before which it plans to",
            d.limits.deceleration_m_s2
        ),
    );
    refuse(
        d.limits.stop_deceleration_m_s2 < d.limits.deceleration_m_s2,
        report,
        "drive.stop_deceleration_m_s2",
        format!("{:?}", d.limits.stop_deceleration_m_s2),
        format!(
            "at least `deceleration_m_s2`, {} m/s²",
            d.limits.deceleration_m_s2
        ),
    );
    refuse(
        d.stop_current_a > d.drive_current_a,
        report,
        "drive.stop_current_a",
        format!("{:?}", d.stop_current_a),
        format!("at most `drive_current_a`, {} A", d.drive_current_a),
    );
    let reachable_m_s = d.limits.max_wheel_speed_rad_s * d.geometry.wheel_diameter_m / 2.0;
    refuse(
        d.limits.max_speed_m_s > reachable_m_s,
        report,
        "drive.max_speed_m_s",
        format!("{:?}", d.limits.max_speed_m_s),
        format!(
            "at most {reachable_m_s:.3} m/s, what `max_wheel_speed_rad_s` and `wheel_diameter_m` allow"
        ),
    );
}

fn ethercat(robot: &RobotConfig, report: &Report) {
    let (d, e) = (&robot.drive, &robot.ethercat);
    let written = !report.touched(&["drive.hold_ms", "ethercat.watchdog_ms"]);
    refuse(
        written && d.hold_ms >= e.watchdog_ms,
        report,
        "drive.hold_ms",
        d.hold_ms.to_string(),
        format!(
            "below `ethercat.watchdog_ms`, {} ms: the drive stops by itself then",
            e.watchdog_ms
        ),
    );
    let fieldbus = robot
        .threads
        .iter()
        .find(|t| t.activities.contains(&ActivityKind::Drive));
    if let Some(Trigger::Period { period }) = fieldbus.map(|thread| thread.trigger) {
        let deadline = Duration::from_micros(e.deadline_us.into());
        refuse(
            !period.is_zero() && deadline > period,
            report,
            "ethercat.deadline_us",
            e.deadline_us.to_string(),
            format!("at most the period of `drive`, {} µs", period.as_micros()),
        );
        refuse(
            period > Duration::from_millis(d.setpoint_timeout_ms.into()),
            report,
            "drive.setpoint_timeout_ms",
            d.setpoint_timeout_ms.to_string(),
            format!("at least the period of `drive`, {} µs", period.as_micros()),
        );
    }
}

fn lidar(robot: &RobotConfig, report: &Report) {
    let l = &robot.lidar;
    refuse(
        l.range_max_m <= l.range_min_m,
        report,
        "lidar.range_max_m",
        format!("{:?}", l.range_max_m),
        format!("above `range_min_m`, {} m", l.range_min_m),
    );
    if report.touched(&["lidar.cluster", "lidar.skip"]) {
        return;
    }
    let readings = URG_04LX_STEPS.div_ceil(l.cluster.max(1));
    let needed = scan_bit_s(scan_bytes(readings as usize, 3), URG_04LX_HZ, l.skip);
    if f64::from(l.bit_rate) < needed && !report.touched(&["lidar.bit_rate"]) {
        let problem = report
            .problem(
                ProblemKind::Inconsistent,
                "lidar.bit_rate",
                l.bit_rate.to_string(),
                format!(
                    "at least {needed:.0} bit/s, which scans at cluster {} and skip {} take",
                    l.cluster, l.skip
                ),
            )
            .with_hint("raise `bit_rate`, `cluster` or `skip`");
        report.push(problem);
    }
    let between_ms = 100 * (l.skip + 1);
    refuse(
        l.scan_timeout_ms <= between_ms,
        report,
        "lidar.scan_timeout_ms",
        l.scan_timeout_ms.to_string(),
        format!(
            "above {between_ms} ms, the time between two scans at skip {}",
            l.skip
        ),
    );
}

fn navigation(robot: &RobotConfig, report: &Report) {
    let (d, n) = (&robot.drive, &robot.navigation);
    let tightest_1_m = d.limits.max_steering_rad.tan() / d.geometry.wheelbase_m;
    refuse(
        n.max_curvature_1_m > tightest_1_m,
        report,
        "navigation.max_curvature_1_m",
        format!("{:?}", n.max_curvature_1_m),
        format!("at most {tightest_1_m:.3} 1/m, what `max_steering_rad` and `wheelbase_m` allow"),
    );
    refuse(
        n.start_std_m >= n.max_std_m,
        report,
        "navigation.start_std_m",
        format!("{:?}", n.start_std_m),
        format!("below `max_std_m`, {} m, or it never starts", n.max_std_m),
    );
    refuse(
        n.start_std_rad >= n.max_std_rad,
        report,
        "navigation.start_std_rad",
        format!("{:?}", n.start_std_rad),
        format!(
            "below `max_std_rad`, {} rad, or it never starts",
            n.max_std_rad
        ),
    );
}

fn tubes(robot: &RobotConfig, report: &Report) {
    let t = &robot.tubes;
    let mount = check_mount(&robot.lidar.mount, &robot.footprint);
    for error in mount
        .err()
        .into_iter()
        .chain(t.contradictions(&robot.footprint))
    {
        refuse(true, report, &error.key, error.found, error.expected);
    }
    if t.horizons.is_empty() || report.touched(&["tubes.horizons"]) {
        return;
    }
    let fastest_m_s = t.fastest_m_s();
    refuse(
        robot.drive.limits.max_speed_m_s > fastest_m_s,
        report,
        "drive.max_speed_m_s",
        format!("{:?}", robot.drive.limits.max_speed_m_s),
        format!("at most {fastest_m_s} m/s, the fastest of `tubes.horizons`"),
    );
}

fn fleet(robot: &RobotConfig, report: &Report) {
    let f = &robot.fleet;
    endpoints("fleet.listen", &f.listen, report);
    endpoints("fleet.connect", &f.connect, report);
    protection(f, report);
    if !f.key_prefix.is_empty() && !is_key_prefix(&f.key_prefix) {
        report.wrong(
            ProblemKind::OutOfRange,
            "fleet.key_prefix",
            format!("text {:?}", f.key_prefix),
            "parts of letters, digits, `-`, `_` or `.` between single `/`",
        );
    }
    if f.scouting && f.interface.is_none() && !report.touched(&["fleet"]) {
        report.wrong(
            ProblemKind::MissingKey,
            "fleet.interface",
            "nothing",
            "the interface to scout on, as `scouting` is true",
        );
    }
    if let (Link::Interface(bus), Some(network)) = (&robot.ethercat.link, &f.interface) {
        refuse(
            bus == network && !bus.is_empty(),
            report,
            "fleet.interface",
            format!("text {network:?}"),
            "an interface other than the fieldbus, `ethercat.interface`".to_owned(),
        );
    }
}

fn endpoints(key: &str, list: &[String], report: &Report) {
    for (index, text) in list.iter().enumerate() {
        if !text.is_empty() && Endpoint::parse(text).is_none() {
            let key = format!("{key}[{index}]");
            let expected = "an endpoint such as \"tls/192.168.1.20:7447\", over `tls` or `tcp`";
            report.wrong(
                ProblemKind::OutOfRange,
                &key,
                format!("text {text:?}"),
                expected,
            );
        }
    }
}

/// Every link has certificates on both ends, or stays on this computer, unless the file says otherwise.
fn protection(fleet: &Fleet, report: &Report) {
    let secure = fleet.keys.is_some();
    if secure && fleet.insecure && !report.touched(&["fleet.insecure"]) {
        report.wrong(
            ProblemKind::Inconsistent,
            "fleet.insecure",
            "true",
            "false, or no `fleet.keys`",
        );
        return;
    }
    if secure && !fleet.listen.is_empty() {
        let found = format!("text {:?}", fleet.listen[0]);
        let expected =
            "no endpoint: with `fleet.keys` a robot connects to its mediator, and nobody to it";
        refuse(true, report, "fleet.listen[0]", found, expected.to_owned());
    }
    if !secure && !fleet.insecure && fleet.scouting && fleet.interface.is_some() {
        let expected =
            "false, or `fleet.keys` with the robot's certificate, or `fleet.insecure = true`";
        refuse(
            true,
            report,
            "fleet.scouting",
            "true".to_owned(),
            expected.to_owned(),
        );
    }
    for (list, of) in [
        ("fleet.listen", &fleet.listen),
        ("fleet.connect", &fleet.connect),
    ] {
        for (index, text) in of.iter().enumerate() {
            let Some(endpoint) = Endpoint::parse(text) else {
                continue;
            };
            let expected = match (secure, endpoint.is_tls) {
                (true, false) => "an endpoint over `tls`, since `fleet.keys` is given",
                (false, true) => {
                    "`fleet.keys` with the robot's certificate, or an endpoint over `tcp`"
                }
                (false, false) if !fleet.insecure && !endpoint.is_loopback() => {
                    "an endpoint over `tls` and `fleet.keys` with the robot's certificate, or `fleet.insecure = true`"
                }
                _ => continue,
            };
            let found = format!("text {text:?}");
            refuse(
                true,
                report,
                &format!("{list}[{index}]"),
                found,
                expected.to_owned(),
            );
        }
    }
}
