//! The sections of a robot file. What has a value that suits every robot is
//! optional; geometry, limits, devices and threads must be written.

use std::f64::consts::{FRAC_PI_2, PI};
use std::net::SocketAddr;
use std::path::PathBuf;
use std::time::Duration;

use crate::choices::{BIT_RATES, CORES, activities};
use crate::diagnostic::ProblemKind;
use crate::quantity::{ANGLE, Count, OFFSET, Quantity, ROBOT_LENGTH, ROBOT_LENGTH_OR_ZERO};
use crate::reader::Section;
use crate::report::Report;
use crate::robot::{
    ControlGains, DriveConfig, EthercatConfig, FleetConfig, Footprint, Identity, LidarConfig, Link,
    NavigationGains, RobotConfig, TubeConfig, TubeHorizon,
};
use crate::threads::{Core, Scheduling, ThreadConfig, Trigger};
use crate::tree::Value;

const SPEED: Quantity = Quantity::new("a speed", "m/s").above(0.0).at_most(3.0);
const ACCELERATION: Quantity = Quantity::new("an acceleration", "m/s²")
    .above(0.0)
    .at_most(10.0);
const CURRENT: Quantity = Quantity::new("a current", "A").above(0.0).at_most(100.0);
const VOLTAGE: Quantity = Quantity::new("a voltage", "V").above(0.0).at_most(100.0);
const GAIN: Quantity = Quantity::new("a gain", "").above(0.0).at_most(1000.0);
const DURATION: Quantity = Quantity::new("a duration", "s").above(0.0).at_most(60.0);
const STD_M: Quantity = Quantity::new("a standard deviation", "m")
    .above(0.0)
    .at_most(10.0);
const STD_RAD: Quantity = Quantity::new("a standard deviation", "rad")
    .above(0.0)
    .at_most(PI);
const STD_RATE: Quantity = Quantity::new("a standard deviation per metre", "")
    .above(0.0)
    .at_most(1.0);
const TIMEOUT_MS: Count = Count::new("a time in ms", 1, 10_000);
const CODE: Count = Count::new("a number that SubDevices report", 1, u32::MAX as i64);

pub(super) fn read(root: &Section<'_>, report: &Report) -> RobotConfig {
    RobotConfig {
        identity: root.section("identity", "a section [identity]", identity),
        footprint: root.section("footprint", "a section [footprint]", footprint),
        drive: root.section("drive", "a section [drive]", drive),
        ethercat: root.section("ethercat", "a section [ethercat]", |s| ethercat(s, report)),
        lidar: root.section("lidar", "a section [lidar]", |s| lidar(s, report)),
        threads: root.section("threads", "sections [threads.<name>]", |s| s.each(thread)),
        control: root.section_or_defaults("control", control),
        navigation: root.section_or_defaults("navigation", navigation),
        tubes: root.section("tubes", "a section [tubes]", tubes),
        fleet: root.section_or_defaults("fleet", |s| fleet(s, report)),
        origin: report.origin.clone(),
    }
}

fn identity(s: &Section<'_>) -> Identity {
    Identity {
        id: s.id("id", "the robot's unique name"),
        model: s
            .text_if("model", "a description")
            .unwrap_or_else(|| "unknown".to_owned()),
    }
}

fn footprint(s: &Section<'_>) -> Footprint {
    Footprint {
        front_m: s.number("front_m", ROBOT_LENGTH),
        rear_m: s.number("rear_m", ROBOT_LENGTH),
        left_m: s.number("left_m", ROBOT_LENGTH),
        right_m: s.number("right_m", ROBOT_LENGTH),
    }
}

fn drive(s: &Section<'_>) -> DriveConfig {
    let wheel_speed = Quantity::new("a speed", "rad/s").above(0.0).at_most(100.0);
    let steering = Quantity::new("an angle", "rad")
        .above(0.0)
        .at_most(FRAC_PI_2);
    let steering_rate = Quantity::new("a rate", "rad/s").above(0.0).at_most(50.0);
    DriveConfig {
        wheelbase_m: s.number("wheelbase_m", ROBOT_LENGTH),
        wheel_diameter_m: s.number("wheel_diameter_m", ROBOT_LENGTH),
        wheel_separation_m: s.number("wheel_separation_m", ROBOT_LENGTH),
        caster_offset_m: s.number("caster_offset_m", ROBOT_LENGTH_OR_ZERO),
        pivot_zero_rad: s.number_or("pivot_zero_rad", ANGLE, 0.0),
        max_wheel_speed_rad_s: s.number("max_wheel_speed_rad_s", wheel_speed),
        max_speed_m_s: s.number("max_speed_m_s", SPEED),
        max_steering_rad: s.number("max_steering_rad", steering),
        max_steering_rate_rad_s: s.number("max_steering_rate_rad_s", steering_rate),
        acceleration_m_s2: s.number("acceleration_m_s2", ACCELERATION),
        deceleration_m_s2: s.number("deceleration_m_s2", ACCELERATION),
        stop_deceleration_m_s2: s.number("stop_deceleration_m_s2", ACCELERATION),
        drive_current_a: s.number("drive_current_a", CURRENT),
        stop_current_a: s.number("stop_current_a", CURRENT),
        min_bus_voltage_v: s.number("min_bus_voltage_v", VOLTAGE),
        max_bus_voltage_v: s.number("max_bus_voltage_v", VOLTAGE),
        setpoint_timeout_ms: s.integer_or("setpoint_timeout_ms", TIMEOUT_MS, 50),
        hold_ms: s.integer_or("hold_ms", TIMEOUT_MS, 20),
        bringups_per_minute: s.integer_or("bringups_per_minute", Count::new("a count", 0, 60), 3),
    }
}

fn ethercat(s: &Section<'_>, report: &Report) -> EthercatConfig {
    EthercatConfig {
        link: link(s, report),
        vendor_id: s.integer("vendor_id", CODE),
        product_codes: s.integers("product_codes", CODE),
        deadline_us: s.integer_or("deadline_us", Count::new("a time in µs", 50, 100_000), 500),
        watchdog_ms: s.integer_or("watchdog_ms", TIMEOUT_MS, 100),
    }
}

fn link(s: &Section<'_>, report: &Report) -> Link {
    const BOTH: &str = "exactly one of `interface` and `udp`";
    let interface = s.text_if("interface", "a network interface, such as \"eth0\"");
    let udp = s.text_if("udp", "an address with port, such as \"127.0.0.1:34980\"");
    match (interface, udp) {
        (Some(interface), None) => {
            // The kernel's IFNAMSIZ, and what `ip link` accepts.
            let bad = interface.len() > 15 || interface.contains(['/', ' ']);
            if bad && !interface.is_empty() {
                report.push(report.problem(
                    ProblemKind::OutOfRange,
                    &s.at("interface"),
                    format!("text {interface:?}"),
                    "the name of a network interface, at most 15 characters",
                ));
            }
            Link::Interface(interface)
        }
        (None, Some(text)) => match text.parse::<SocketAddr>() {
            Ok(address) if address.port() != 0 => Link::Udp(address),
            _ => {
                if !text.is_empty() {
                    report.push(report.problem(
                        ProblemKind::OutOfRange,
                        &s.at("udp"),
                        format!("text {text:?}"),
                        "an IP address with port, such as \"127.0.0.1:34980\"",
                    ));
                }
                Link::Interface(String::new())
            }
        },
        (Some(_), Some(_)) => {
            let problem = report.problem(
                ProblemKind::Inconsistent,
                &s.at("udp"),
                "both of them",
                BOTH,
            );
            report.push(report.origin.also(problem, &s.at("interface"), "and here"));
            Link::Interface(String::new())
        }
        (None, None) => {
            if report.origin.is_written("ethercat") {
                report.push(report.problem(
                    ProblemKind::MissingKey,
                    &s.at("interface"),
                    "neither",
                    BOTH,
                ));
            }
            Link::Interface(String::new())
        }
    }
}

fn lidar(s: &Section<'_>, report: &Report) -> LidarConfig {
    let range = Quantity::new("a range", "m").above(0.0).at_most(60.0);
    let rates: Vec<String> = BIT_RATES.iter().map(u32::to_string).collect();
    let device = s.text("device", "a serial device, such as \"/dev/ttyACM0\"");
    if !device.is_empty() && !device.starts_with('/') {
        let key = s.at("device");
        let found = format!("text {device:?}");
        report.push(report.problem(ProblemKind::OutOfRange, &key, found, "an absolute path"));
    }
    LidarConfig {
        device: PathBuf::from(device),
        bit_rate: s
            .custom(
                "bit_rate",
                &format!("one of {} bit/s", rates.join(", ")),
                |value| match value {
                    Value::Integer(rate) => {
                        BIT_RATES.iter().copied().find(|r| i64::from(*r) == *rate)
                    }
                    _ => None,
                },
            )
            .unwrap_or_default(),
        mount: s.pose("mount", OFFSET),
        range_min_m: s.number("range_min_m", range),
        range_max_m: s.number("range_max_m", range),
        cluster: s.integer_or("cluster", Count::new("a count", 1, 99), 1),
        skip: s.integer_or("skip", Count::new("a count", 0, 9), 0),
        scan_timeout_ms: s.integer_or("scan_timeout_ms", TIMEOUT_MS, 250),
        good_scans_s: s.number_or("good_scans_s", DURATION, 2.0),
    }
}

fn thread(name: &str, s: &Section<'_>) -> ThreadConfig {
    #[derive(Clone, Copy)]
    enum Kind {
        Period,
        Lidar,
        Scan,
        Async,
    }
    let period = Count::new("a time in µs", 250, 1_000_000);
    let kind = s.choice(
        "trigger",
        &[
            ("period", Kind::Period),
            ("lidar", Kind::Lidar),
            ("scan", Kind::Scan),
            ("async", Kind::Async),
        ],
    );
    let trigger = match kind {
        Some(Kind::Period) => {
            Trigger::Period(Duration::from_micros(s.integer("period_us", period).into()))
        }
        Some(Kind::Scan) => {
            let at_least = s.integer("at_least_ms", Count::new("a time in ms", 1, 1000));
            Trigger::Scan {
                at_least: Duration::from_millis(at_least.into()),
            }
        }
        Some(Kind::Lidar) => Trigger::Lidar,
        Some(Kind::Async) => Trigger::Async,
        None => {
            // The trigger is wrong; its parameters are not to blame.
            let _ = (s.has("period_us"), s.has("at_least_ms"));
            Trigger::Async
        }
    };
    let scheduling = match s.choice("scheduling", &[("fifo", true), ("normal", false)]) {
        Some(true) => {
            let priority = s.integer("priority", Count::new("a real-time priority", 1, 99));
            Scheduling::Fifo(u8::try_from(priority).unwrap_or_default())
        }
        Some(false) => Scheduling::Normal,
        None => {
            let _ = s.has("priority");
            Scheduling::Normal
        }
    };
    let core = s.custom(
        "core",
        "`big`, `little`, `any` or a core's number",
        |value| match value {
            Value::Text(text) => CORES
                .iter()
                .find(|(name, _)| name == text)
                .map(|(_, core)| *core),
            Value::Integer(number) => usize::try_from(*number)
                .ok()
                .filter(|n| *n < 1024)
                .map(Core::Number),
            _ => None,
        },
    );
    ThreadConfig {
        name: name.to_owned(),
        activities: s
            .choices("activities", &activities(), true)
            .into_iter()
            .flatten()
            .collect(),
        trigger,
        scheduling,
        core: core.unwrap_or(Core::Any),
    }
}

fn control(s: &Section<'_>) -> ControlGains {
    let pivot = Quantity::new("an angle", "rad").above(0.0).at_most(PI);
    ControlGains {
        pivot_gain_1_s: s.number_or("pivot_gain_1_s", GAIN, 5.0),
        pivot_error_max_rad: s.number_or("pivot_error_max_rad", pivot, PI / 4.0),
        align_rad: s.number_or("align_rad", pivot, 0.6),
        command_timeout_ms: s.integer_or("command_timeout_ms", TIMEOUT_MS, 150),
    }
}

fn navigation(s: &Section<'_>) -> NavigationGains {
    let lookahead = Quantity::new("a length", "m").above(0.0).at_most(5.0);
    let curvature = Quantity::new("a curvature", "1/m").above(0.0).at_most(20.0);
    let inlier = Quantity::new("a length", "m").above(0.0).at_most(1.0);
    let lag = Quantity::new("a duration", "s").at_least(0.0).at_most(2.0);
    let gate = Quantity::new("a number of standard deviations", "")
        .at_least(1.0)
        .at_most(10.0);
    let start_m = Quantity::new("a standard deviation", "m")
        .at_least(0.0)
        .at_most(10.0);
    let start_rad = Quantity::new("a standard deviation", "rad")
        .at_least(0.0)
        .at_most(PI);
    NavigationGains {
        lateral_gain_1_m2: s.number_or("lateral_gain_1_m2", GAIN, 4.0),
        heading_gain_1_m: s.number_or("heading_gain_1_m", GAIN, 4.0),
        lookahead_m: s.number_or("lookahead_m", lookahead, 0.6),
        max_curvature_1_m: s.number_or("max_curvature_1_m", curvature, 2.5),
        deceleration_m_s2: s.number_or("deceleration_m_s2", ACCELERATION, 0.4),
        steering_lag_s: s.number_or("steering_lag_s", lag, 0.2),
        wall_inlier_m: s.number_or("wall_inlier_m", inlier, 0.05),
        wall_min_points: s.integer_or("wall_min_points", Count::new("a count", 2, 10_000), 12),
        range_std_m: s.number_or("range_std_m", inlier, 0.01),
        gate_sigma: s.number_or("gate_sigma", gate, 4.0),
        odometry_std_m_per_m: s.number_or("odometry_std_m_per_m", STD_RATE, 0.03),
        odometry_std_rad_per_m: s.number_or("odometry_std_rad_per_m", STD_RATE, 0.03),
        start_std_m: s.number_or("start_std_m", start_m, 0.10),
        start_std_rad: s.number_or("start_std_rad", start_rad, 0.10),
        max_std_m: s.number_or("max_std_m", STD_M, 0.30),
        max_std_rad: s.number_or("max_std_rad", STD_RAD, 0.30),
        border_sigma: s.number_or("border_sigma", gate, 3.0),
    }
}

fn tubes(s: &Section<'_>) -> TubeConfig {
    let horizon = Quantity::new("a duration", "s").above(0.0).at_most(10.0);
    let omega = Quantity::new("a turn rate", "rad/s")
        .above(0.0)
        .at_most(10.0);
    let step = Quantity::new("a length", "m").at_least(0.01).at_most(1.0);
    let curvature = Quantity::new("a curvature", "1/m")
        .at_least(0.0)
        .at_most(20.0);
    let reaction = Quantity::new("a duration", "s").at_least(0.0).at_most(1.0);
    let way = Quantity::new("a length", "m").at_least(0.0).at_most(20.0);
    let heading = Quantity::new("an angle", "rad")
        .at_least(0.0)
        .at_most(FRAC_PI_2);
    let moving = Quantity::new("a speed", "m/s").at_least(0.0).at_most(5.0);
    let margin = Quantity::new("a length", "m").at_least(0.0).at_most(2.0);
    let retreat = margin;
    let rows = |key: &'static str| {
        s.list(key, "tables { horizon_s = …, speed_m_s = … }", |s| {
            TubeHorizon {
                horizon_s: s.number("horizon_s", horizon),
                speed_m_s: s.number("speed_m_s", SPEED),
            }
        })
    };
    TubeConfig {
        horizons: rows("horizons"),
        backward_horizons: if s.has("backward_horizons") {
            rows("backward_horizons")
        } else {
            Vec::new()
        },
        omega_max_rad_s: s.number_or("omega_max_rad_s", omega, FRAC_PI_2),
        omega_steps: s.integer_or("omega_steps", Count::new("an odd count", 3, 501), 41),
        sample_step_m: s.number_or("sample_step_m", step, 0.05),
        augment_m: s.number_or("augment_m", step, 0.06),
        curvature_band_1_m: s.number_or("curvature_band_1_m", curvature, 0.4),
        speed_weight: s.number_or("speed_weight", GAIN, 4.0),
        hysteresis_1_m: s.number_or("hysteresis_1_m", curvature, 0.2),
        free_scans: s.integer_or("free_scans", Count::new("a number of scans", 1, 50), 3),
        reaction_s: s.number_or("reaction_s", reaction, 0.1),
        resume_after_s: s.number_or("resume_after_s", DURATION, 2.0),
        memory_s: s.number_or("memory_s", DURATION, 2.0),
        floor_memory_m: s.number_or("floor_memory_m", way, 2.0),
        detour_curvature_1_m: s.number_or("detour_curvature_1_m", curvature, 2.5),
        detour_heading_rad: s.number_or("detour_heading_rad", heading, 1.5),
        detour_speed_m_s: s.number_or("detour_speed_m_s", SPEED, 0.25),
        detour_after_s: s.number_or("detour_after_s", DURATION, 0.1),
        detour_retreat_m: s.number_or("detour_retreat_m", retreat, 0.4),
        moving_speed_m_s: s.number_or("moving_speed_m_s", moving, 1.0),
        moving_margin_m: s.number_or("moving_margin_m", margin, 0.05),
        moving_rest_s: s.number_or("moving_rest_s", DURATION, 4.0),
    }
}

fn fleet(s: &Section<'_>, report: &Report) -> FleetConfig {
    let endpoint = "an endpoint such as \"tcp/192.168.1.20:7447\"";
    let endpoints = |key: &'static str| {
        let list = s.texts(key, endpoint);
        for (index, text) in list.iter().enumerate() {
            if !text.is_empty() && !is_endpoint(text) {
                let key = format!("{}[{index}]", s.at(key));
                let found = format!("text {text:?}");
                report.push(report.problem(ProblemKind::OutOfRange, &key, found, endpoint));
            }
        }
        list
    };
    let ahead = Quantity::new("a length", "m").at_least(0.0).at_most(20.0);
    let key_prefix = s.text_if("key_prefix", "the first part of every key");
    if let Some(prefix) = key_prefix.as_deref().filter(|prefix| !prefix.is_empty()) {
        let bad_part = |part: &str| part.is_empty() || part.contains(['*', '$', '?', '#', ' ']);
        if prefix.split('/').any(bad_part) {
            report.push(report.problem(
                ProblemKind::OutOfRange,
                &s.at("key_prefix"),
                format!("text {prefix:?}"),
                "parts between single `/`, without `*`, `$`, `?`, `#` or space",
            ));
        }
    }
    FleetConfig {
        listen: endpoints("listen"),
        connect: endpoints("connect"),
        scouting: s.boolean_or("scouting", false),
        interface: s.text_if("interface", "a network interface, such as \"wlan0\""),
        key_prefix: key_prefix.unwrap_or_else(|| "fleet".to_owned()),
        request_ahead_m: s.number_or("request_ahead_m", ahead, 0.5),
    }
}

/// `protocol/address`, with one of the transports that are built in.
fn is_endpoint(text: &str) -> bool {
    match text.split_once('/') {
        Some(("tcp" | "udp" | "tls", address)) => {
            let address = address.split(['?', '#']).next().unwrap_or_default();
            address
                .rsplit_once(':')
                .is_some_and(|(host, port)| !host.is_empty() && port.parse::<u16>().is_ok())
        }
        _ => false,
    }
}
