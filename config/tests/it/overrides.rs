//! `--set key=value`, files that cannot be read, and robot and site together.

use std::io::Write;

use crate::common::{ROBOT, SITE, edit, lines, sets};
use config::ProblemKind::{
    File, MissingKey, OutOfRange, Override as BadOverride, Syntax, UnknownKey, UnknownReference,
    WrongType,
};
use config::{
    ConfigError, Override, Problem, ProblemKind, check_together, load_robot, load_site,
    parse_robot, parse_site,
};
use description::robot::Link;

fn only(error: &ConfigError) -> &Problem {
    let [problem] = error.problems() else {
        panic!("{}", lines(error))
    };
    problem
}

#[test]
fn overrides_replace_values_in_the_file_that_has_the_section() {
    let overrides = sets(&[
        "drive.max_speed_m_s=0.3",
        "lidar.device=/tmp/pty-3",
        "ethercat.udp = 127.0.0.1:5000",
        "fleet.listen=[\"tcp/127.0.0.1:7000\"]",
        "threads.fieldbus.core=any",
        "areas.managed=true",
        "areas.1.speed_limit_m_s=0.2",
        "robots.amr-1.start={ x_m = 3.0, y_m = -0.5, theta_rad = 0.0 }",
    ]);
    let robot =
        parse_robot("robot.toml", ROBOT, &overrides).unwrap_or_else(|e| panic!("{}", lines(&e)));
    assert_eq!(robot.drive.limits.max_speed_m_s, 0.3);
    assert_eq!(robot.lidar.device.to_str(), Some("/tmp/pty-3"));
    assert_eq!(
        robot.ethercat.link,
        Link::Udp("127.0.0.1:5000".parse().unwrap())
    );
    assert_eq!(robot.fleet.listen, ["tcp/127.0.0.1:7000"]);
    assert_eq!(robot.threads[0].core, description::threads::Core::Any);
    assert_eq!(robot.origin.line("drive.max_speed_m_s"), None);
    assert!(robot.origin.line("drive.max_wheel_speed_rad_s").is_some());
    let site =
        parse_site("site.toml", SITE, &overrides).unwrap_or_else(|e| panic!("{}", lines(&e)));
    assert!(site.areas_managed);
    assert_eq!(site.area("1").unwrap().control.speed_limit_m_s, 0.2);
    assert_eq!(site.robots["amr-1"].start.x_m, 3.0);
}

#[test]
fn the_last_override_of_a_key_holds() {
    let overrides = sets(&["drive.max_speed_m_s=9.9", "drive.max_speed_m_s=0.2"]);
    let robot =
        parse_robot("robot.toml", ROBOT, &overrides).unwrap_or_else(|e| panic!("{}", lines(&e)));
    assert_eq!(robot.drive.limits.max_speed_m_s, 0.2);
}

#[test]
fn a_bad_override_is_named() {
    let cases: &[(&str, ProblemKind, &str, &str, &str)] = &[
        (
            "drive.max_speed_m_s=-1",
            OutOfRange,
            "drive.max_speed_m_s",
            "-1",
            "a speed above 0",
        ),
        (
            "drive.max_speed_m_s=nan",
            OutOfRange,
            "drive.max_speed_m_s",
            "NaN",
            "a speed above 0",
        ),
        (
            "drive.max_speed_m_s=slow",
            WrongType,
            "drive.max_speed_m_s",
            "text \"slow\"",
            "a speed",
        ),
        (
            "drive.max_sped_m_s=1",
            UnknownKey,
            "drive.max_sped_m_s",
            "unknown key `max_sped_m_s`",
            "in [drive]",
        ),
        ("drive=3", WrongType, "drive", "3", "a section [drive]"),
        (
            "drive.wheelbase_m.x=1",
            BadOverride,
            "drive.wheelbase_m",
            "0.25",
            "a table",
        ),
        (
            "tubes.horizons.x=1",
            BadOverride,
            "tubes.horizons",
            "an array of 5 values",
            "a table",
        ),
        ("threads.extra.core=any", MissingKey, "", "", ""),
    ];
    for (typed, kind, key, found, expected) in cases {
        let error = parse_robot("robot.toml", ROBOT, &sets(&[typed])).expect_err(typed);
        let file = format!("--set {typed}");
        assert!(
            error.problems().iter().all(|p| p.file == file),
            "{typed}: {}",
            lines(&error)
        );
        assert!(
            error.problems().iter().all(|p| p.line.is_none()),
            "{typed}: {}",
            lines(&error)
        );
        assert!(
            crate::common::render(&error).contains(typed),
            "{}",
            crate::common::render(&error)
        );
        if *kind == MissingKey {
            continue;
        }
        let problem = only(&error);
        assert_eq!(
            (problem.kind, problem.key.as_str()),
            (*kind, *key),
            "{problem}"
        );
        assert_eq!(problem.found, *found, "{problem}");
        assert!(problem.expected.contains(expected), "{problem}");
    }
}

#[test]
fn an_override_of_the_wrong_shape_is_refused() {
    let cases: &[(&str, &str, &str, &str)] = &[
        (
            "drive.max_speed_m_s",
            "",
            "`drive.max_speed_m_s`",
            "key=value",
        ),
        ("=3", "", "the key ``", "key=value"),
        ("drive..x=3", "drive..x", "the key `drive..x`", "key=value"),
        ("drive.x=", "drive.x", "nothing", "a value behind the `=`"),
        (
            "drve.x=1",
            "drve.x",
            "`drve`",
            "one of `identity`, `footprint`, `drive`",
        ),
        ("drive.x=[1", "drive.x", "`[1`", "a TOML value ("),
        (
            "drive.a.a.a.a.a.a.a.a=1",
            "",
            "a key of 9 parts",
            "at most 8 parts",
        ),
    ];
    for (typed, key, found, expected) in cases {
        let error = Override::parse(typed).expect_err(typed);
        let problem = only(&error);
        assert_eq!(problem.kind, BadOverride, "{problem}");
        assert_eq!(problem.file, format!("--set {typed}"));
        assert_eq!(problem.key, *key, "{problem}");
        assert_eq!(problem.found, *found, "{problem}");
        assert!(problem.expected.contains(expected), "{problem}");
    }
    let near = Override::parse("drve.x=1").unwrap_err();
    assert_eq!(only(&near).hint.as_deref(), Some("did you mean `drive`?"));
}

#[test]
fn a_file_that_cannot_be_read_is_named() {
    let folder = tempfile::tempdir().unwrap();
    let missing = folder.path().join("none.toml");
    let error = load_robot(&missing, &[]).unwrap_err();
    let problem = only(&error);
    assert_eq!(
        (problem.kind, problem.found.as_str()),
        (File, "no such file")
    );
    assert_eq!(problem.file, missing.display().to_string());
    assert_eq!(problem.expected, "a readable robot file in TOML");

    let error = load_site(folder.path(), &[]).unwrap_err();
    assert_eq!(only(&error).found, "a directory");
    assert_eq!(only(&error).expected, "a readable site file in TOML");

    let binary = folder.path().join("binary.toml");
    std::fs::File::create(&binary)
        .unwrap()
        .write_all(b"name = \"x\"\n\n\xff\xfe")
        .unwrap();
    let error = load_site(&binary, &[]).unwrap_err();
    let problem = only(&error);
    assert_eq!((problem.kind, problem.line), (Syntax, Some(3)));
    assert_eq!(problem.found, "the byte 0xFF");

    let huge = folder.path().join("huge.toml");
    std::fs::write(&huge, vec![b'#'; (1 << 20) + 1]).unwrap();
    assert_eq!(
        only(&load_robot(&huge, &[]).unwrap_err()).found,
        "a file over 1024 KiB"
    );

    assert_eq!(
        only(&load_robot("/dev/zero", &[]).unwrap_err()).found,
        "something that is no file"
    );
}

fn together(robot: &str, site: &str) -> Result<(), ConfigError> {
    let robot = parse_robot("robot.toml", robot, &[]).unwrap_or_else(|e| panic!("{}", lines(&e)));
    let site = parse_site("site.toml", site, &[]).unwrap_or_else(|e| panic!("{}", lines(&e)));
    check_together(&robot, &site)
}

#[test]
fn the_shipped_files_fit_together() {
    together(ROBOT, SITE).unwrap_or_else(|error| panic!("{}", lines(&error)));
}

#[test]
fn a_site_that_does_not_know_the_robot() {
    let other = edit(ROBOT, "id = \"amr-1\"", "id = \"amr-2\"");
    let error = together(&other, SITE).expect_err("refused");
    let problem = only(&error);
    assert_eq!(
        (problem.file.as_str(), problem.key.as_str(), problem.kind),
        ("robot.toml", "identity.id", UnknownReference)
    );
    assert_eq!(
        problem.found,
        "robot `amr-2`, which site.toml does not have"
    );
    assert!(problem.expected.contains("[robots.amr-2]"), "{problem}");
    assert!(problem.line.is_some(), "{problem}");
}

#[test]
fn two_errors_print_as_one() {
    let robot = parse_robot("robot.toml", "", &[]).unwrap_err();
    let site = parse_site("site.toml", "", &[]).unwrap_err();
    let both = robot.and(site);
    assert_eq!(both.to_string(), "16 problems in the configuration");
    let text = crate::common::render(&both);
    assert!(
        text.contains("robot.toml:1: identity") && text.contains("site.toml:1: name"),
        "{text}"
    );
}
