//! The robot file: what ships loads, and every kind of mistake is named precisely.

use std::time::Duration;

use crate::common::{Mistake, ROBOT, check, edit, line_of, lines};
use config::ProblemKind::{
    Duplicate, Inconsistent, MissingKey, OutOfRange, Syntax, UnknownKey, WrongType,
};
use config::{ConfigError, RobotConfig, load_robot, parse_robot};
use description::robot::Link;
use description::threads::{ActivityKind, Core, Scheduling, Trigger};

fn fails(file: &str, text: &str) -> Option<ConfigError> {
    parse_robot(file, text, &[]).err()
}

fn shipped() -> RobotConfig {
    load_robot("robots/amr-1.toml", &[]).unwrap_or_else(|error| panic!("{}", lines(&error)))
}

#[test]
fn the_shipped_robot_is_the_one_of_the_scenarios() {
    let robot = shipped();
    assert_eq!(robot.identity.id, "amr-1");
    let f = robot.footprint;
    assert_eq!(
        (f.front_m, f.rear_m, f.left_m, f.right_m),
        (0.32, 0.08, 0.15, 0.15)
    );
    assert_eq!(robot.drive.geometry.wheelbase_m, 0.25);
    assert_eq!(robot.drive.limits.max_wheel_speed_rad_s, 35.0);
    assert_eq!(robot.drive.limits.stop_deceleration_m_s2, 2.0);
    assert_eq!(
        robot.ethercat.link,
        Link::Udp("127.0.0.1:34980".parse().unwrap())
    );
    assert_eq!(
        robot.ethercat.product_codes,
        [24_137_745, 0x1701_0091, 0x0200_1001]
    );
    assert_eq!(robot.lidar.mount.x_m, 0.28);
    assert_eq!(
        robot.tubes.horizons.len() * robot.tubes.omega_steps as usize,
        205
    );
    assert_eq!(robot.tubes.omega_max_rad_s, std::f64::consts::FRAC_PI_2);
}

#[test]
fn as_many_turn_rates_as_tubes_take_are_allowed() {
    let with = |steps: u32| {
        let text = edit(
            ROBOT,
            "omega_steps = 41 ",
            &format!("omega_steps = {steps} "),
        );
        parse_robot("amr-1.toml", &text, &[])
    };
    assert_eq!(with(1001).unwrap().tubes.omega_steps, 1001);
    let error = with(1003).unwrap_err();
    assert_eq!(error.problems()[0].key, "tubes.omega_steps");
}

#[test]
fn the_shipped_thread_table_has_five_threads() {
    let robot = shipped();
    let table: Vec<_> = robot
        .threads
        .iter()
        .map(|t| {
            (
                t.name.as_str(),
                t.activities.as_slice(),
                t.trigger,
                t.scheduling,
                t.core,
            )
        })
        .collect();
    use ActivityKind as A;
    let at_least = Duration::from_millis(50);
    assert_eq!(
        table,
        [
            (
                "fieldbus",
                &[A::Drive][..],
                Trigger::Period {
                    period: Duration::from_millis(1)
                },
                Scheduling::Fifo { priority: 80 },
                Core::Big
            ),
            (
                "motion",
                &[A::Proprioception, A::Control],
                Trigger::Period {
                    period: Duration::from_millis(5)
                },
                Scheduling::Fifo { priority: 70 },
                Core::Big
            ),
            (
                "lidar",
                &[A::Lidar],
                Trigger::Lidar,
                Scheduling::Fifo { priority: 60 },
                Core::Little
            ),
            (
                "navigation",
                &[A::Navigation, A::MotionTube],
                Trigger::Scan { at_least },
                Scheduling::Fifo { priority: 50 },
                Core::Big
            ),
            (
                "communication",
                &[A::Communication],
                Trigger::Async,
                Scheduling::Normal,
                Core::Little
            ),
        ]
    );
}

#[test]
fn written_defaults_are_the_defaults() {
    let full = shipped();
    // Without its two sections of gains, and the lines marked so.
    let start = ROBOT.find("# Motion command to wheel").unwrap();
    let end = ROBOT.find("# Motion tubes: the floor").unwrap();
    let fleet = ROBOT.find("# zenoh, between").unwrap();
    let text = format!("{}{}", &ROBOT[..start], &ROBOT[end..fleet]);
    let short: String = text
        .lines()
        .filter(|line| !line.contains("default"))
        .map(|line| format!("{line}\n"))
        .collect();
    let robot = parse_robot("short.toml", &short, &[]).unwrap_or_else(|e| panic!("{}", lines(&e)));
    assert_eq!(robot.drive, full.drive);
    assert_eq!(robot.ethercat, full.ethercat);
    assert_eq!(robot.lidar, full.lidar);
    assert_eq!(robot.navigation, full.navigation);
    assert_eq!(robot.tubes, full.tubes);
    assert_eq!(robot.fleet, full.fleet);
    assert!((robot.control.pivot_error_max_rad - full.control.pivot_error_max_rad).abs() < 1e-3);
}

#[test]
fn numbers_and_keys() {
    let mistakes = [
        Mistake {
            name: "unit in the key",
            from: "wheelbase_m = 0.25 ",
            to: "wheelbase_mm = 250 ",
            kind: UnknownKey,
            key: "drive.wheelbase_mm",
            line: "wheelbase_mm = 250",
            found: "unknown key `wheelbase_mm`",
            expected: "a known key in [drive]: `wheelbase_m`, ",
            hint: "did you mean `wheelbase_m`? It is in metres.",
        },
        Mistake {
            name: "no unit in the key",
            from: "period_us = 1000",
            to: "period = 1000",
            kind: UnknownKey,
            key: "threads.fieldbus.period",
            line: "period = 1000",
            found: "unknown key `period`",
            expected: "`period_us`",
            hint: "did you mean `period_us`? It is in microseconds.",
        },
        Mistake {
            name: "misspelt key",
            from: "range_max_m = 4.0",
            to: "rnage_max_m = 4.0",
            kind: UnknownKey,
            key: "lidar.rnage_max_m",
            line: "rnage_max_m",
            found: "unknown key `rnage_max_m`",
            expected: "in [lidar]",
            hint: "did you mean `range_max_m`?",
        },
        Mistake {
            name: "unknown section",
            from: "[fleet]",
            to: "[battery]\ncells = 6\n\n[fleet]",
            kind: UnknownKey,
            key: "battery",
            line: "[battery]",
            found: "unknown key `battery`",
            expected: "at the top of the file: `metamodel`, `identity`",
            hint: "",
        },
        Mistake {
            name: "unit in the value",
            from: "wheel_diameter_m = 0.105",
            to: "wheel_diameter_m = \"105 mm\"",
            kind: WrongType,
            key: "drive.wheel_diameter_m",
            line: "\"105 mm\"",
            found: "text \"105 mm\"",
            expected: "a length above 0 and at most 5 m",
            hint: "write the number alone: 0.105",
        },
        Mistake {
            name: "millimetres for metres",
            from: "front_m = 0.32",
            to: "front_m = 320",
            kind: OutOfRange,
            key: "footprint.front_m",
            line: "front_m = 320",
            found: "320",
            expected: "at most 5 m",
            hint: "320 mm is 0.32 m",
        },
        Mistake {
            name: "degrees for radians",
            from: "max_steering_rad = 1.2",
            to: "max_steering_rad = 70.0",
            kind: OutOfRange,
            key: "drive.max_steering_rad",
            line: "max_steering_rad = 70.0",
            found: "70.0",
            expected: "an angle above 0 and at most 1.570796 rad",
            hint: "70 ° is 1.22173 rad",
        },
        Mistake {
            name: "text for a number",
            from: "max_speed_m_s = 0.40",
            to: "max_speed_m_s = \"fast\"",
            kind: WrongType,
            key: "drive.max_speed_m_s",
            line: "\"fast\"",
            found: "text \"fast\"",
            expected: "a speed above 0 and at most 3 m/s",
            hint: "without quotes",
        },
        Mistake {
            name: "float for a whole number",
            from: "watchdog_ms = 100",
            to: "watchdog_ms = 100.5",
            kind: WrongType,
            key: "ethercat.watchdog_ms",
            line: "watchdog_ms",
            found: "100.5",
            expected: "a whole number from 1 to 10000",
            hint: "",
        },
        Mistake {
            name: "number for a truth value",
            from: "scouting = false",
            to: "scouting = 0",
            kind: WrongType,
            key: "fleet.scouting",
            line: "scouting = 0",
            found: "0",
            expected: "true or false",
            hint: "",
        },
        Mistake {
            name: "number for a table",
            from: "mount = { x_m = 0.28, y_m = 0.0, theta_rad = 0.0 }",
            to: "mount = 0.28",
            kind: WrongType,
            key: "lidar.mount",
            line: "mount = 0.28",
            found: "0.28",
            expected: "a pose { x_m",
            hint: "",
        },
        Mistake {
            name: "NaN",
            from: "acceleration_m_s2 = 0.5",
            to: "acceleration_m_s2 = nan",
            kind: OutOfRange,
            key: "drive.acceleration_m_s2",
            line: "acceleration_m_s2 = nan",
            found: "NaN",
            expected: "an acceleration above 0",
            hint: "",
        },
        Mistake {
            name: "infinity",
            from: "y_m = 0.0",
            to: "y_m = -inf",
            kind: OutOfRange,
            key: "lidar.mount.y_m",
            line: "y_m = -inf",
            found: "-inf",
            expected: "an offset at least -5 and at most 5 m",
            hint: "",
        },
        Mistake {
            name: "a number beyond any float",
            from: "rear_m = 0.08",
            to: "rear_m = 1e999",
            kind: OutOfRange,
            key: "footprint.rear_m",
            line: "rear_m = 1e999",
            found: "inf",
            expected: "a length",
            hint: "",
        },
        Mistake {
            name: "negative length",
            from: "wheel_separation_m = 0.0775",
            to: "wheel_separation_m = -0.0775",
            kind: OutOfRange,
            key: "drive.wheel_separation_m",
            line: "wheel_separation_m",
            found: "-0.0775",
            expected: "a length above 0",
            hint: "",
        },
        Mistake {
            name: "an integer beyond 64 bits",
            from: "hold_ms = 20 ",
            to: "hold_ms = 99999999999999999999 ",
            kind: OutOfRange,
            key: "drive.hold_ms",
            line: "hold_ms",
            found: "99999999999999999999",
            expected: "a whole number from 1 to 10000",
            hint: "",
        },
        Mistake {
            name: "missing key",
            from: "stop_deceleration_m_s2 = 2.0      # of every stop for a fault\n",
            to: "",
            kind: MissingKey,
            key: "drive.stop_deceleration_m_s2",
            line: "[drive]",
            found: "nothing",
            expected: "an acceleration above 0 and at most 10 m/s²",
            hint: "",
        },
        Mistake {
            name: "missing section",
            from: "[footprint]\nfront_m = 0.32\nrear_m = 0.08\nleft_m = 0.15\nright_m = 0.15\n",
            to: "",
            kind: MissingKey,
            key: "footprint",
            line: "# One robot",
            found: "nothing",
            expected: "a section [footprint]",
            hint: "",
        },
        Mistake {
            name: "an id that cannot be a name",
            from: "id = \"amr-1\"",
            to: "id = \"amr/1\"",
            kind: OutOfRange,
            key: "identity.id",
            line: "amr/1",
            found: "the name \"amr/1\"",
            expected: "letters, digits, `-` and `_`",
            hint: "",
        },
    ];
    check(&mistakes, ROBOT, fails);
}

#[test]
fn threads() {
    let mistakes = [
        Mistake {
            name: "activity on no thread",
            from: "\"proprioception\", ",
            to: "",
            kind: MissingKey,
            key: "threads",
            line: "[threads.fieldbus]",
            found: "activity `proprioception` on no thread",
            expected: "`proprioception` in `activities` of exactly one thread",
            hint: "the threads are `fieldbus`, `motion`",
        },
        Mistake {
            name: "activity on two threads",
            from: "activities = [\"navigation\", ",
            to: "activities = [\"navigation\", \"control\", ",
            kind: Duplicate,
            key: "threads.navigation.activities[1]",
            line: "activities = [\"navigation\", \"control\"",
            found: "`control` on thread `motion` and on `navigation`",
            expected: "each activity on exactly one thread",
            hint: "",
        },
        Mistake {
            name: "unknown activity",
            from: "\"motion-tube\"]",
            to: "\"motion-tubes\"]",
            kind: OutOfRange,
            key: "threads.navigation.activities[1]",
            line: "\"motion-tubes\"]",
            found: "text \"motion-tubes\"",
            expected: "`motion-tube`",
            hint: "did you mean `motion-tube`?",
        },
        Mistake {
            name: "priority too high",
            from: "priority = 80",
            to: "priority = 100",
            kind: OutOfRange,
            key: "threads.fieldbus.priority",
            line: "priority = 100",
            found: "100",
            expected: "a real-time priority, a whole number from 1 to 99",
            hint: "",
        },
        Mistake {
            name: "priority too low",
            from: "priority = 60",
            to: "priority = 0",
            kind: OutOfRange,
            key: "threads.lidar.priority",
            line: "priority = 0",
            found: "0",
            expected: "from 1 to 99",
            hint: "",
        },
        Mistake {
            name: "priority without real-time scheduling",
            from: "scheduling = \"normal\"",
            to: "scheduling = \"normal\"\npriority = 3",
            kind: UnknownKey,
            key: "threads.communication.priority",
            line: "priority = 3",
            found: "unknown key `priority`",
            expected: "in [threads.communication]",
            hint: "",
        },
        Mistake {
            name: "unknown core",
            from: "priority = 60\ncore = \"little\"",
            to: "priority = 60\ncore = \"small\"",
            kind: OutOfRange,
            key: "threads.lidar.core",
            line: "core = \"small\"",
            found: "text \"small\"",
            expected: "`big`, `little`, `any` or a core's number",
            hint: "",
        },
        Mistake {
            name: "no period",
            from: "period_us = 1000\n",
            to: "",
            kind: MissingKey,
            key: "threads.fieldbus.period_us",
            line: "[threads.fieldbus]",
            found: "nothing",
            expected: "a time in µs",
            hint: "",
        },
        Mistake {
            name: "real-time network",
            from: "scheduling = \"normal\"",
            to: "scheduling = \"fifo\"\npriority = 10",
            kind: Inconsistent,
            key: "threads.communication.scheduling",
            line: "scheduling = \"fifo\"\npriority = 10",
            found: "`fifo` 10",
            expected: "`normal`",
            hint: "",
        },
        Mistake {
            name: "the same thread twice",
            from: "[threads.motion]",
            to: "[threads.fieldbus]",
            kind: Duplicate,
            key: "threads.fieldbus",
            line: "[threads.fieldbus]\nactivities = [\"propr",
            found: "`fieldbus` a second time",
            expected: "each name once",
            hint: "",
        },
    ];
    check(&mistakes, ROBOT, fails);
}

#[test]
fn devices_and_network() {
    let mistakes = [
        Mistake {
            name: "two links",
            from: "udp = \"127.0.0.1:34980\"\nvendor",
            to: "interface = \"eth0\"\nudp = \"127.0.0.1:34980\"\nvendor",
            kind: Inconsistent,
            key: "ethercat.udp",
            line: "udp = \"127.0.0.1:34980\"\nvendor",
            found: "both of them",
            expected: "exactly one of `interface` and `udp`",
            hint: "",
        },
        Mistake {
            name: "no link",
            from: "udp = \"127.0.0.1:34980\"\nvendor",
            to: "vendor",
            kind: MissingKey,
            key: "ethercat.interface",
            line: "[ethercat]",
            found: "neither",
            expected: "exactly one of",
            hint: "",
        },
        Mistake {
            name: "no port",
            from: "udp = \"127.0.0.1:34980\"\nvendor",
            to: "udp = \"127.0.0.1\"\nvendor",
            kind: OutOfRange,
            key: "ethercat.udp",
            line: "udp = \"127.0.0.1\"\n",
            found: "text \"127.0.0.1\"",
            expected: "an IP address with port",
            hint: "",
        },
        Mistake {
            name: "a product code of nothing",
            from: "[0x01705011, 0x17010091,",
            to: "[0x01705011, 0,",
            kind: OutOfRange,
            key: "ethercat.product_codes[1]",
            line: "product_codes = [",
            found: "0",
            expected: "from 1 to 4294967295",
            hint: "",
        },
        Mistake {
            name: "a vendor beyond 32 bits",
            from: "vendor_id = 0x4B454C4F",
            to: "vendor_id = 0x1FFFFFFFF",
            kind: OutOfRange,
            key: "ethercat.vendor_id",
            line: "vendor_id =",
            found: "8589934591",
            expected: "from 1 to 4294967295",
            hint: "",
        },
        Mistake {
            name: "unknown bit rate",
            from: "bit_rate = 500000",
            to: "bit_rate = 9600",
            kind: OutOfRange,
            key: "lidar.bit_rate",
            line: "bit_rate = 9600",
            found: "9600",
            expected: "one of 19200, 38400, 57600, 115200",
            hint: "",
        },
        Mistake {
            name: "a bit rate that cannot carry the scans",
            from: "bit_rate = 500000",
            to: "bit_rate = 115200",
            kind: Inconsistent,
            key: "lidar.bit_rate",
            line: "bit_rate = 115200",
            found: "115200",
            expected: "at least 213700 bit/s, which scans at cluster 1 and skip 0 take",
            hint: "raise `bit_rate`, `cluster` or `skip`",
        },
        Mistake {
            name: "deadline after the cycle",
            from: "deadline_us = 500",
            to: "deadline_us = 1500",
            kind: Inconsistent,
            key: "ethercat.deadline_us",
            line: "deadline_us = 1500",
            found: "1500",
            expected: "at most the period of `drive`, 1000 µs",
            hint: "",
        },
        Mistake {
            name: "tubes that leave objects unseen",
            from: "augment_m = 0.1 ",
            to: "augment_m = 0.02",
            kind: Inconsistent,
            key: "tubes.augment_m",
            line: "augment_m = 0.02",
            found: "0.02",
            expected: "at least 0.025 m, half of `sample_step_m`",
            hint: "",
        },
        Mistake {
            name: "tubes with gaps",
            from: "omega_steps = 41 ",
            to: "omega_steps = 31 ",
            kind: Inconsistent,
            key: "tubes.omega_steps",
            line: "omega_steps = 31",
            found: "31",
            expected: "over 34.5, so that neighbouring tubes end less than the robot's width, 0.3 m, apart",
            hint: "",
        },
        Mistake {
            name: "an even number of turn rates",
            from: "omega_steps = 41 ",
            to: "omega_steps = 40 ",
            kind: Inconsistent,
            key: "tubes.omega_steps",
            line: "omega_steps = 40",
            found: "40",
            expected: "an odd count",
            hint: "",
        },
        Mistake {
            name: "a sensor off the robot",
            from: "mount = { x_m = 0.28,",
            to: "mount = { x_m = 0.38,",
            kind: Inconsistent,
            key: "lidar.mount",
            line: "mount = { x_m = 0.38",
            found: "a sensor at (0.38, 0.0)",
            expected: "a sensor inside the footprint",
            hint: "",
        },
        Mistake {
            name: "faster than every tube",
            from: "max_speed_m_s = 0.40",
            to: "max_speed_m_s = 0.60",
            kind: Inconsistent,
            key: "drive.max_speed_m_s",
            line: "max_speed_m_s = 0.60",
            found: "0.6",
            expected: "at most 0.4 m/s, the fastest of `tubes.horizons`",
            hint: "",
        },
        Mistake {
            name: "horizons in the wrong order",
            from: "{ horizon_s = 3.0,",
            to: "{ horizon_s = 1.5,",
            kind: Inconsistent,
            key: "tubes.horizons[3].horizon_s",
            line: "{ horizon_s = 1.5,",
            found: "1.5",
            expected: "a longer way than the one before it, 2 s at 0.3 m/s",
            hint: "",
        },
        Mistake {
            name: "not an endpoint",
            from: "connect = [] ",
            to: "connect = [\"192.168.1.2\"] ",
            kind: OutOfRange,
            key: "fleet.connect[0]",
            line: "connect = [\"192",
            found: "text \"192.168.1.2\"",
            expected: "an endpoint such as",
            hint: "",
        },
        Mistake {
            name: "a transport that is not built in",
            from: "connect = [] ",
            to: "connect = [\"udp/192.168.1.2:7447\"] ",
            kind: OutOfRange,
            key: "fleet.connect[0]",
            line: "connect = [\"udp",
            found: "text \"udp/192.168.1.2:7447\"",
            expected: "over `tls` or `tcp`",
            hint: "",
        },
        Mistake {
            name: "a key prefix that the network refuses",
            from: "key_prefix = \"fleet\"",
            to: "key_prefix = \"halle:1\"",
            kind: OutOfRange,
            key: "fleet.key_prefix",
            line: "key_prefix = \"halle",
            found: "text \"halle:1\"",
            expected: "parts of letters, digits",
            hint: "",
        },
        Mistake {
            name: "scouting anywhere",
            from: "scouting = false",
            to: "scouting = true",
            kind: MissingKey,
            key: "fleet.interface",
            line: "[fleet]",
            found: "nothing",
            expected: "the interface to scout on",
            hint: "",
        },
    ];
    check(&mistakes, ROBOT, fails);
}

#[test]
fn links_without_certificates() {
    let far = |name, to: &'static str, line, found, expected| Mistake {
        name,
        from: "connect = [] ",
        to,
        kind: Inconsistent,
        key: "fleet.connect[0]",
        line,
        found,
        expected,
        hint: "",
    };
    let mistakes = [
        far(
            "beyond this computer",
            "connect = [\"tcp/192.168.1.2:7447\"] ",
            "connect = [\"tcp",
            "text \"tcp/192.168.1.2:7447\"",
            "`fleet.keys` with the robot's certificate, or `fleet.insecure = true`",
        ),
        far(
            "no certificate to show",
            "connect = [\"tls/192.168.1.2:7447\"] ",
            "connect = [\"tls",
            "text \"tls/192.168.1.2:7447\"",
            "`fleet.keys` with the robot's certificate",
        ),
        far(
            "nobody to show it to",
            "connect = [\"tcp/127.0.0.1:7447\"]\nkeys = \"amr-1.pem\" ",
            "connect = [\"tcp",
            "text \"tcp/127.0.0.1:7447\"",
            "an endpoint over `tls`",
        ),
        Mistake {
            name: "a robot to which others connect",
            from: "listen = [] ",
            to: "listen = [\"tls/0.0.0.0:7447\"]\nkeys = \"amr-1.pem\" ",
            kind: Inconsistent,
            key: "fleet.listen[0]",
            line: "listen = [\"tls",
            found: "text \"tls/0.0.0.0:7447\"",
            expected: "no endpoint",
            hint: "",
        },
        Mistake {
            name: "multicast",
            from: "scouting = false",
            to: "interface = \"wlan0\"\nscouting = true",
            kind: Inconsistent,
            key: "fleet.scouting",
            line: "scouting = true",
            found: "true",
            expected: "`fleet.keys`",
            hint: "",
        },
        Mistake {
            name: "certificates and none",
            from: "scouting = false",
            to: "scouting = false\nkeys = \"amr-1.pem\"\ninsecure = true",
            kind: Inconsistent,
            key: "fleet.insecure",
            line: "insecure = true",
            found: "true",
            expected: "false, or no `fleet.keys`",
            hint: "",
        },
    ];
    check(&mistakes, ROBOT, fails);
}

#[test]
fn syntax() {
    let mistakes = [
        Mistake {
            name: "no value",
            from: "rear_m = 0.08",
            to: "rear_m =",
            kind: Syntax,
            key: "footprint.rear_m",
            line: "rear_m =",
            found: "`rear_m =`",
            expected: "valid TOML (",
            hint: "",
        },
        Mistake {
            name: "the same key twice",
            from: "left_m = 0.15",
            to: "front_m = 0.15",
            kind: Duplicate,
            key: "footprint.front_m",
            line: "front_m = 0.15",
            found: "`front_m` a second time",
            expected: "each name once",
            hint: "",
        },
        Mistake {
            name: "no quotes",
            from: "model = \"0.4 x 0.3 m platform, KELO drive 100, URG-04LX\"",
            to: "model = platform",
            kind: Syntax,
            key: "identity.model",
            line: "model = platform",
            found: "`model = platform                    # for people`",
            expected: "valid TOML (",
            hint: "",
        },
    ];
    let no_comment = edit(ROBOT, "URG-04LX\"   # for people", "URG-04LX\"");
    check(&mistakes[..2], ROBOT, fails);
    let mistake = Mistake {
        found: "`model = platform`",
        ..mistakes.into_iter().nth(2).unwrap()
    };
    check(&[mistake], &no_comment, fails);
}

#[test]
fn everything_wrong_is_said_at_once_in_the_order_of_the_file() {
    let mut text = edit(ROBOT, "front_m = 0.32", "front_m = -1");
    text = edit(&text, "wheelbase_m = 0.25 ", "wheelbase_mm = 250 ");
    text = edit(&text, "bit_rate = 500000", "bit_rate = 1");
    text = edit(&text, "priority = 70", "priority = 700");
    let error = fails("some.toml", &text).unwrap();
    let keys: Vec<&str> = error
        .problems()
        .iter()
        .map(|problem| problem.key.as_str())
        .collect();
    assert_eq!(
        keys,
        [
            "footprint.front_m",
            "drive.wheelbase_mm",
            "lidar.bit_rate",
            "threads.motion.priority"
        ]
    );
    assert_eq!(
        error.problems()[3].line,
        Some(line_of(&text, "priority = 700"))
    );
    assert_eq!(error.to_string(), "4 problems in the configuration");
    let rendered = crate::common::render(&error);
    for key in keys {
        assert!(rendered.contains(key), "{rendered}");
    }
}

#[test]
fn an_empty_file_lacks_its_sections_and_says_no_more() {
    let error = fails("empty.toml", "").unwrap();
    let keys: Vec<&str> = error
        .problems()
        .iter()
        .map(|problem| problem.key.as_str())
        .collect();
    assert_eq!(
        keys,
        [
            "identity",
            "footprint",
            "drive",
            "ethercat",
            "lidar",
            "threads",
            "tubes"
        ],
        "{}",
        lines(&error)
    );
}

#[test]
fn a_thousand_mistakes_are_cut_off() {
    let mut text = ROBOT.to_owned();
    for index in 0..1000 {
        text.push_str(&format!("nonsense_{index} = 1\n"));
    }
    let error = fails("some.toml", &text).unwrap();
    assert_eq!(error.problems().len(), 100);
    assert_eq!(
        error.to_string(),
        "1000 problems in the configuration, the first 100 are shown"
    );
}

#[test]
fn every_shipped_robot_fits_the_sites_that_name_it() {
    let site = |name: &str| {
        config::load_site(format!("sites/{name}.toml"), &[])
            .unwrap_or_else(|error| panic!("{name}: {}", lines(&error)))
    };
    for (file, id, sites) in [
        (
            "amr-1",
            "amr-1",
            &["corridor", "docking", "t-junction", "course"][..],
        ),
        ("amr-1", "amr-2", &["docking", "t-junction"]),
        ("amr-1", "amr-3", &["t-junction"]),
        ("amr-big", "amr-big", &["docking"]),
    ] {
        let other_id = crate::common::sets(&[&format!("identity.id={id}")]);
        let robot = config::load_robot(format!("robots/{file}.toml"), &other_id)
            .unwrap_or_else(|error| panic!("{file}: {}", lines(&error)));
        for name in sites {
            config::check_together(&robot, &site(name))
                .unwrap_or_else(|error| panic!("{id} in {name}: {}", lines(&error)));
        }
    }
}

#[test]
fn a_file_may_name_its_metamodel_and_no_other() {
    let bare = ROBOT.replace("metamodel = \"urn:kelo-onboard:robot:1\"\n", "");
    assert!(bare.len() < ROBOT.len(), "what is shipped names it");
    let with = |urn: &str| format!("metamodel = \"{urn}\"\n{bare}");
    let known = parse_robot("amr-1.toml", &with("urn:kelo-onboard:robot:1"), &[]);
    let without = parse_robot("amr-1.toml", &bare, &[]);
    assert_eq!(known.unwrap().value, without.unwrap().value);
    let error = fails("amr-1.toml", &with("urn:kelo-onboard:robot:2")).expect("refused");
    let text = lines(&error);
    assert!(text.contains("amr-1.toml:1: metamodel: found"), "{text}");
    for part in [
        "metamodel",
        "urn:kelo-onboard:robot:2",
        "urn:kelo-onboard:robot:1",
    ] {
        assert!(text.contains(part), "{text}");
    }
    let site = "metamodel = \"urn:kelo-onboard:robot:1\"\n";
    let error = config::parse_site("s.toml", site, &[]).expect_err("a robot's");
    assert!(
        lines(&error).contains("urn:kelo-onboard:site:1"),
        "{}",
        lines(&error)
    );
}
