//! The chain of activities under another thread table than the shipped one.

use std::f64::consts::TAU;

use coordination::activity::LifeCycleEvent;
use coordination::event::queue;
use coordination::symbols::{Inspector, Namespace};
use description::geometry::Pose2;
use description::threads::Trigger;
use description::wheels::{EncoderAngles, WheelSpeeds};
use skills::scan::ScanGeometry;

use super::beginning::Beginning;
use super::compose::{by_thread, compose_chain};
use super::files::Files;
use super::plan::Plan;
use super::replacement::ReloadHands;
use crate::activities::port::{COMMANDS, Port, REPORTS};
use crate::fleet::Began;
use crate::realtime::clock::{MILLISECOND_NS, SECOND_NS};
use crate::realtime::log;
use crate::symbols::values::{
    Encoders, PoseEstimate, RangeScan, RobotMode, SafeCommand, TubeState,
};
use crate::symbols::wiring::{ACTIVITIES, Wiring};

const BEGIN_NS: u64 = SECOND_NS;
const STEP_NS: u64 = 5 * MILLISECOND_NS;
const SCAN_NS: u64 = 100 * MILLISECOND_NS;
const SPEED_M_S: f64 = 0.2;

/// What the chain has made of a scan.
#[derive(Debug)]
struct Outcome {
    pose: PoseEstimate,
    safe: SafeCommand,
    tubes: TubeState,
}

/// Metres driven since the beginning.
fn way_m(at_ns: f64) -> f64 {
    SPEED_M_S * (at_ns - BEGIN_NS as f64) / SECOND_NS as f64
}

/// A scan in the empty corridor, 10 m by 3.2 m, from the robot on its way east.
fn scan(geometry: &ScanGeometry, start: Pose2, stamp_ns: u64) -> RangeScan {
    let mut scan = RangeScan {
        count: geometry.beams as u64,
        ..RangeScan::default()
    };
    for (beam, range_mm) in scan.ranges_mm.iter_mut().take(geometry.beams).enumerate() {
        let turned_s = geometry.turn_s * geometry.angle_step_rad * beam as f64 / TAU;
        let way_m = way_m(stamp_ns as f64 + turned_s * SECOND_NS as f64);
        let (x_m, y_m) = (start.x_m + way_m + geometry.mount.x_m, start.y_m);
        let (sin, cos) = geometry.beam_angle_rad(beam).sin_cos();
        let to_end_m = (if cos > 0.0 { 10.0 - x_m } else { -x_m }) / cos;
        let to_side_m = (1.6_f64.copysign(sin) - y_m) / sin;
        // Without noise, scans between the long walls would be all the same, as those of a frozen sensor are.
        let noise_mm = ((beam as u64 + stamp_ns / SCAN_NS) % 3) as f64;
        *range_mm = (to_end_m.min(to_side_m) * 1000.0 + noise_mm).min(4095.0) as u16;
    }
    scan
}

/// Drives east along the corridor for four seconds, with `set` changed in the files.
fn drive(set: &[&str]) -> Vec<Outcome> {
    let config = concat!(env!("CARGO_MANIFEST_DIR"), "/../config");
    let plan = Plan::load(&Files {
        robot: format!("{config}/robots/amr-1.toml").into(),
        site: format!("{config}/sites/corridor.toml").into(),
        set: set.iter().map(|&one| one.to_owned()).collect(),
    })
    .expect("good files");
    let folder = tempfile::tempdir().expect("temporary folder");
    let place = Namespace::new(folder.path(), "chain_");
    let wiring = Wiring::build("amr-1", &place, &[]).expect("built");
    let mut ports = { ACTIVITIES.into_iter().zip(wiring.states) }
        .map(|(kind, state)| {
            let mut port = Port::new(queue(COMMANDS).1, queue(REPORTS).0, state);
            for event in [
                LifeCycleEvent::Configure,
                LifeCycleEvent::Configured,
                LifeCycleEvent::Run,
            ] {
                port.step(event);
            }
            (kind, port)
        })
        .collect();
    let (log, _drain) = log::queue();
    let beginning =
        Beginning::of(&plan, None, Began::Afresh { ended: None }, &log).expect("a navigator");
    let (_hands, ends) = ReloadHands::pair();
    let (mut bus, mut lidar) = (wiring.symbols.drive, wiring.symbols.lidar);
    let mut supervisor = wiring.symbols.supervisor;
    let chain = wiring.symbols.chain;
    let chain = compose_chain(&plan, beginning, chain, &mut ports, ends, None).expect("a chain");
    let mut threads = by_thread(&plan, chain, wiring.scans).expect("threads");
    let inspector = Inspector::open("amr-1", &place).expect("built");
    let mut pose = inspector.reader::<PoseEstimate>("map").expect("a symbol");
    let mut safe = inspector.reader::<SafeCommand>("safe").expect("a symbol");
    let mut tubes = inspector.reader::<TubeState>("adaptive").expect("a symbol");
    let geometry = plan.scan_geometry().expect("scans");
    let radius_m = plan.robot.drive.geometry.wheel_radius_m();
    let mut outcomes = Vec::new();
    for step in 0..=800 {
        let now_ns = BEGIN_NS + step * STEP_NS;
        let turned_rad = way_m(now_ns as f64) / radius_m;
        let encoders = Encoders {
            angles: EncoderAngles {
                left_rad: turned_rad,
                right_rad: turned_rad,
                pivot_rad: 0.0,
            },
            speeds: WheelSpeeds::new(SPEED_M_S / radius_m, SPEED_M_S / radius_m),
            ..Encoders::default()
        };
        bus.encoders.write(now_ns, &encoders);
        supervisor.mode.write(now_ns, &RobotMode::default());
        let scanned = step > 0 && now_ns.is_multiple_of(SCAN_NS);
        if scanned {
            let stamp_ns = now_ns - SCAN_NS;
            let scan = scan(&geometry, plan.start.start, stamp_ns);
            lidar.scan.write(stamp_ns, &scan);
        }
        for (table, thread) in plan.robot.threads.iter().zip(&mut threads) {
            if scanned || !matches!(table.trigger, Trigger::Scan { .. }) {
                thread.step(|| now_ns);
            }
        }
        if scanned {
            outcomes.push(Outcome {
                pose: pose.read().value,
                safe: safe.read().value,
                tubes: TubeState {
                    evaluation_ns: 0, // by the real clock
                    ..tubes.read().value
                },
            });
        }
    }
    outcomes
}

#[test]
fn navigation_and_motion_tube_make_the_same_of_scans_on_one_thread_and_on_two() {
    let one = drive(&[]);
    let two = drive(&[
        "threads.navigation.activities=[\"navigation\"]",
        "threads.tubes={ activities = [\"motion-tube\"], trigger = \"scan\", at_least_ms = 50, \
         scheduling = \"fifo\", priority = 50, core = \"big\" }",
    ]);
    for (one, two) in one.iter().zip(&two) {
        assert_eq!(format!("{one:?}"), format!("{two:?}"));
    }
    let last = two.last().expect("scans");
    // Both looked: walls have corrected the pose, and after two seconds of good scans the way is free.
    assert!(last.pose.std_y_m < 0.05, "{last:?}");
    assert!(last.tubes.free_tubes > 0 && last.safe.stop == 0, "{last:?}");
    assert!(last.safe.command.speed_m_s > 0.1, "{last:?}");
}
