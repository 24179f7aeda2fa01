use std::path::PathBuf;

use description::geometry::{MotionCommand, Twist2};
use description::threads::{ActivityKind, ThreadConfig};
use skills::borders::AreaSet;
use skills::navigator::{NavigationInput, NavigationOutput, Navigator};
use skills::odometry::Odometry;

use super::*;
use crate::composition::failure::Failure;
use crate::composition::files::Files;
use crate::process::overruns::patience_s;

mod budget;
/// Broken files and what must be said about them, as for the loader's own tests.
#[path = "../../../../../config/tests/it/common/mod.rs"]
mod common;
mod refused;

const FILES: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../config");

fn files(robot: &str, site: &str, set: &[&str]) -> Files {
    Files {
        robot: PathBuf::from(format!("{FILES}/robots/{robot}.toml")),
        site: PathBuf::from(format!("{FILES}/sites/{site}.toml")),
        set: set.iter().map(|&one| one.to_owned()).collect(),
    }
}

fn plan(site: &str, set: &[&str]) -> Plan {
    match Plan::load(&files("amr-1", site, set)) {
        Ok(plan) => plan,
        Err(failure) => panic!("{failure:?}"),
    }
}

fn refusal(files: &Files) -> String {
    match Plan::load(files) {
        Ok(_) => panic!("accepted"),
        Err(Failure::Refused(report) | Failure::Failed(report)) => squeezed(&format!("{report:?}")),
    }
}

/// Long lines are broken anywhere.
fn squeezed(text: &str) -> String {
    text.replace([' ', '\n', '│'], "")
}

/// A drive that is slow to come up is no fault of a robot whose file says so, nor a thread that hangs.
#[test]
fn how_long_a_bring_up_may_take_is_its_files_to_say() {
    let plan = plan("corridor", &["ethercat.bring_up_s=7.5"]);
    let timeout = plan.drive_settings().bring_up.timeout;
    assert_eq!(timeout, std::time::Duration::from_millis(7500));
    let drives = |thread: &&ThreadConfig| thread.activities.contains(&ActivityKind::Drive);
    let thread = plan.robot.threads.iter().find(drives).expect("it has one");
    assert_eq!(patience_s(&plan.robot, thread), 8 + 1);
}

#[test]
fn every_shipped_pair_of_files_makes_a_robot() {
    for (robot, id, site) in [
        ("amr-1", "amr-1", "corridor"),
        ("amr-1", "amr-1", "course"),
        ("amr-1", "amr-2", "docking"),
        ("amr-1", "amr-3", "t-junction"),
        ("amr-big", "amr-big", "docking"),
    ] {
        let id = format!("identity.id={id}");
        if let Err(failure) = Plan::load(&files(robot, site, &[&id])) {
            panic!("{robot} in {site}: {failure:?}");
        }
    }
}

#[test]
fn what_cannot_be_driven_is_told_at_its_key() {
    // The turn does not fit between the lanes and the walls.
    let text = refusal(&files(
        "amr-1",
        "t-junction",
        &["skills.turn-right.radius_m=4.0"],
    ));
    for part in ["t-junction.toml", "fsm.west-south.states.cross-to-3"] {
        assert!(text.contains(&squeezed(part)), "{part:?} is not in {text}");
    }
    // A border that the lane does not lead to; a stop beside it; a curve that the robot cannot drive; and all at once.
    let border = "skills.stop-before-junction.before_area=\"7\"";
    let pose = "skills.park.pose={ x_m = 5.2, y_m = -0.5, theta_rad = 0.0 }";
    let tight = "navigation.max_curvature_1_m=0.8";
    let of_border = [
        "skills.stop-before-junction.before_area",
        "area `7`, which lane `east-1` of state `approach-J` does not lead to",
    ];
    let of_pose = [
        "skills.park.pose",
        "(5.2, -0.5, 0.0 rad), 0.700 m from lane `shoulder` of state `park-5`",
    ];
    let of_curve = [
        "course.toml",
        "at least 1.250 m, for the robot's `navigation.max_curvature_1_m`",
    ];
    for (set, parts) in [
        (&[border][..], &[of_border][..]),
        (&[pose], &[of_pose]),
        (&[tight], &[of_curve]),
        (&[border, pose, tight], &[of_border, of_pose, of_curve]),
    ] {
        let text = refusal(&files("amr-1", "course", set));
        for part in parts.as_flattened() {
            assert!(text.contains(&squeezed(part)), "{part:?} is not in {text}");
        }
    }
    // The robot would hit the wall before it has turned.
    let text = refusal(&files(
        "amr-1",
        "course",
        &["skills.back-off.distance_m=-0.02"],
    ));
    for part in ["skills.back-off.distance_m", "0.640 m before the wall"] {
        assert!(text.contains(&squeezed(part)), "{part:?} is not in {text}");
    }
}

#[test]
fn a_reload_exchanges_limits_and_not_hardware() {
    let present = plan("corridor", &[]);
    let with = |set: &str| present.first_fixed_difference(&plan("corridor", &[set]));
    for exchanged in [
        "drive.max_speed_m_s=0.3",
        "drive.acceleration_m_s2=0.4",
        "drive.max_steering_rad=1.1",
        "control.pivot_gain_1_s=4.0",
        "navigation.lookahead_m=0.5",
        "tubes.memory_s=1.5",
        "areas.1.speed_limit_m_s=0.3",
    ] {
        assert_eq!(with(exchanged), None, "{exchanged}");
    }
    for (fixed, key) in [
        ("drive.wheelbase_m=0.26", "drive.wheelbase_m"),
        (
            "drive.stop_deceleration_m_s2=1.8",
            "drive.stop_deceleration_m_s2",
        ),
        (
            "control.command_timeout_ms=140",
            "control.command_timeout_ms",
        ),
        ("lidar.good_scans_s=1.0", "lidar"),
        ("identity.model=other", "identity"),
        ("watchdog.device=/dev/watchdog", "watchdog"),
    ] {
        assert_eq!(with(fixed).as_deref(), Some(key));
    }
    for key in ["sample_step_m=0.04", "augment_m=0.07", "floor_memory_m=2.0"] {
        let found = with(&format!("tubes.{key}"));
        let name = key.split('=').next().map(|key| format!("tubes.{key}"));
        assert_eq!(found, name);
    }
    // By which its side of the mediator reckons.
    let managed = plan("overtaking", &[]);
    for key in [
        "navigation.deceleration_m_s2=0.3",
        "navigation.border_sigma=2.5",
        "navigation.map_error_m=0.02",
    ] {
        let found = managed.first_fixed_difference(&plan("overtaking", &[key]));
        let name = key.split('=').next().unwrap_or_default();
        assert!(found.is_some_and(|found| found.starts_with(name)), "{key}");
        assert_eq!(with(key), None, "{key}");
    }
    // With it the robot asks earlier or later.
    let faster = plan("overtaking", &["drive.max_speed_m_s=0.3"]);
    assert_eq!(managed.first_fixed_difference(&faster), None);
}

/// Drives a navigator as if its commands were followed at once and its odometry were perfect.
struct Drive {
    odometry: Odometry,
}

impl Drive {
    const STEP_NS: u64 = 50_000_000;

    fn new() -> Self {
        Self {
            odometry: Odometry::default(),
        }
    }

    fn step(&mut self, navigator: &mut Navigator) -> NavigationOutput {
        self.odometry.stamp_ns += Self::STEP_NS;
        let output = navigator.step(&NavigationInput {
            now_ns: self.odometry.stamp_ns,
            scan: None,
            odometry: &self.odometry,
            lost: false,
            motion_allowed: true,
            by_hand: None,
            allowed: AreaSet::ALL,
        });
        let MotionCommand {
            speed_m_s,
            curvature_1_m,
        } = output.command;
        let twist = Twist2::new(speed_m_s, speed_m_s * curvature_1_m);
        let step_s = Self::STEP_NS as f64 * 1e-9;
        self.odometry.pose = self.odometry.pose.advance(twist, step_s);
        self.odometry.twist = twist;
        self.odometry.distance_m += speed_m_s.abs() * step_s;
        output
    }
}

/// Half of a creep before a reload and half after it are one creep.
#[test]
fn a_reload_goes_on_with_the_manoeuvre_under_way() {
    let set = [
        "robots.amr-1.start={ x_m = 14.0, y_m = -0.5, theta_rad = 0.0 }",
        "robots.amr-1.start_state=back-off-3",
    ];
    let before = plan("course", &set);
    let after = plan(
        "course",
        &[
            &set[..],
            &["navigation.lookahead_m=0.5", "tubes.memory_s=1.5"],
        ]
        .concat(),
    );
    let mut drive = Drive::new();
    let mut old = before.navigator().expect("good");
    while drive.odometry.distance_m < 0.35 {
        let output = drive.step(&mut old);
        assert!(
            output.command.speed_m_s <= 0.0 && !output.pose_uncertain,
            "{output:?}"
        );
    }
    let mut new = after.navigator().expect("good");
    assert!(new.take_over(&old));
    let pose = |drive: &mut Drive, navigator: &mut Navigator| drive.step(navigator).pose;
    let at = pose(&mut drive, &mut new);
    assert!((at.x_m - 13.65).abs() < 0.03, "{at:?}");
    let name = |navigator: &Navigator| {
        let machine = navigator.machine();
        machine.state_name(machine.state()).to_owned()
    };
    let mut steps = 0;
    while name(&new) == "back-off-3" {
        drive.step(&mut new);
        steps += 1;
        assert!(steps < 400, "{:?}", drive.odometry);
    }
    assert_eq!(name(&new), "leave-3");
    let way_m = drive.odometry.distance_m;
    assert!(
        (0.68..0.74).contains(&way_m),
        "{way_m:.3} m, expected 0.70 m in all"
    );
}
