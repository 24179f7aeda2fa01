//! The lidar is unplugged, hangs, or its bytes are broken.

use onboard::process::ctl::{Done, Request};
use onboard::symbols::faults::Fault;
use sim::lidar::Disturbance;
use sim::world::{Pose, Shape};

use crate::stepped::bench::Bench;

/// Scans are missed after 250 ms; a cycle or two later motors are told to stop.
const NOTICED_S: f64 = 0.3;

#[test]
fn without_a_lidar_it_stops_and_with_it_drives_on() {
    let mut bench = Bench::driving();
    bench.is_stopped(NOTICED_S, |bench| bench.devices.unplug_lidar());
    assert!(bench.has(Fault::LidarLost) && bench.has(Fault::ScanSilent));
    bench.stands_for(5.0);
    bench.devices.plug_in_lidar(bench.now_ns);
    // 2 s of good scans come first.
    bench.stands_for(2.0);
    bench.until_driving();
    assert!(!bench.has(Fault::LidarLost) && !bench.has(Fault::ScanSilent));
    bench.finish();
}

#[test]
fn a_lidar_that_hangs_stops_it() {
    let mut bench = Bench::driving();
    disturb(&bench, Disturbance::Freeze { frozen: true });
    bench.is_stopped(NOTICED_S, |_| {});
    bench.stands_for(2.0);
    disturb(&bench, Disturbance::Freeze { frozen: false });
    bench.stands_for(2.0);
    bench.until_driving();
    bench.finish();
}

#[test]
fn broken_scans_are_dropped_and_it_goes_on() {
    let mut bench = Bench::driving();
    // Every second or third scan is broken, in one way after the other.
    for round in 0..12 {
        disturb(
            &bench,
            match round % 3 {
                0 => Disturbance::Garbage { bytes: 700 },
                1 => Disturbance::TruncateScans { scans: 1 },
                _ => Disturbance::CorruptScans { scans: 1 },
            },
        );
        bench.watch(0.25);
    }
    assert!(bench.raised(Fault::ScanBroken) > 0);
    bench.until_driving();

    // Nothing but broken scans: as good as none.
    bench.is_stopped(NOTICED_S, |bench| {
        disturb(bench, Disturbance::CorruptScans { scans: 20 });
    });
    bench.until_driving();
    bench.finish();
}

#[test]
fn a_delay_that_grows_is_not_taken_for_drift() {
    /// From the start of a turn to step 44, the first that is measured.
    const TO_FIRST_BEAM_MS: f64 = 44.0 / 1024.0 * TURN_MS;
    const TURN_MS: f64 = 100.0;
    /// A robot at full speed drives this long for 4 mm.
    const MOST_OFF_MS: f64 = 10.0;
    let mut bench = Bench::driving();
    let connections = bench.lidar().connections;
    bench.devices.delay_lidar_more_and_more(0.001, bench.now_ns);
    // In 200 s it grows to 200 ms.
    for _ in 0..2000 {
        bench.watch(0.1);
        let stamp_ns = bench.scan_stamp_ns() as f64;
        let turn_ms =
            (stamp_ns - bench.devices.lidar_turn_start_ns() as f64) / 1e6 - TO_FIRST_BEAM_MS;
        let off_ms = turn_ms - (turn_ms / TURN_MS).round() * TURN_MS;
        assert!(
            off_ms.abs() < MOST_OFF_MS,
            "scans are older by {off_ms} ms than it says"
        );
    }
    let lidar = bench.lidar();
    assert!(lidar.untrusted > 0, "{lidar:?}");
    // Its clock cannot be compared any more: people are told.
    assert!(bench.has(Fault::LidarLost) && bench.has(Fault::ScanSilent));
    bench.stands_for(5.0);
    bench.devices.delay_lidar_more_and_more(0.0, bench.now_ns);
    bench.until_driving();
    assert!(!bench.has(Fault::LidarLost));
    assert!(bench.lidar().connections > connections);
    bench.finish();
}

#[test]
fn a_covered_lidar_shows_no_free_floor_and_stops_it() {
    let mut bench = Bench::driving();
    // Nobody would see this.
    let wall = bench.add(Shape::Box {
        pose: bench.ahead(0.32 + 1.2),
        length_m: 0.1,
        width_m: 3.0,
    });
    bench.is_stopped(NOTICED_S, |bench| {
        disturb(bench, Disturbance::Cover { covered: true });
    });
    assert!(bench.has(Fault::LidarBlind) && bench.has(Fault::ScanSilent));
    bench.stands_for(20.0);
    assert!(bench.world.lock().remove_obstacle(wall));
    disturb(&bench, Disturbance::Cover { covered: false });
    bench.stands_for(1.9);
    bench.until_driving();
    assert!(!bench.has(Fault::LidarBlind) && !bench.has(Fault::ScanSilent));
    assert!(!bench.has(Fault::PoseUncertain));
    bench.finish();
}

/// Where it takes itself to be no wall is in reach, but that may be elsewhere: what has no echo is no free floor.
#[test]
fn a_covered_lidar_stops_a_lost_robot_in_somebodys_hands() {
    let beside = Shape::Box {
        pose: Pose::new(4.5, -1.7, 0.0),
        length_m: 4.0,
        width_m: 0.2,
    };
    let hall = [
        "walls.south={ from_m = [-1.0, -9.0], to_m = [13.0, -9.0] }",
        "walls.north={ from_m = [-1.0, 9.0], to_m = [13.0, 9.0] }",
    ];
    // Whatever its pose is corrected by: one that is certain, where no wall is to be seen, is no less elsewhere.
    for tracks in ["\"corridor\"", "\"corridor\", \"walls\""] {
        let tracks = format!("perception.kinds.A.tracks=[{tracks}]");
        let set = [hall[0], hall[1], &tracks];
        let mut bench = Bench::new(Pose::new(4.0, -0.5, 0.0), 0.0, &[beside], &set);
        bench.watch(3.0);
        bench.be_lost_in_hands();
        bench.desk().want(0.0, 0.0);
        bench.watch(0.2);
        bench.desk().want(0.2, 0.0);
        bench.until("it creeps", 3.0, |bench| bench.truth().twist.v_m_s > 0.05);
        disturb(&bench, Disturbance::Cover { covered: true });
        bench.until_standing(1.0);
        bench.stands_for(2.0);
        disturb(&bench, Disturbance::Cover { covered: false });
        bench.until("it creeps on", 6.0, |bench| {
            bench.truth().twist.v_m_s > 0.05
        });
        bench.finish();
    }
}

/// Scans that stay the same to the millimetre while the robot drives come from a memory, and not from a turn.
#[test]
fn a_lidar_that_repeats_its_last_scan_is_connected_anew_and_drives_on() {
    let mut bench = Bench::driving();
    let connections = bench.lidar().connections;
    disturb(&bench, Disturbance::Repeat { repeats: true });
    let began_m = bench.truth().distance_m;
    bench.until_standing(3.0);
    // It drives a tenth of a metre until it can know, and brakes.
    let driven_m = bench.truth().distance_m - began_m;
    assert!((0.1..0.4).contains(&driven_m), "{driven_m} m");
    // Nobody has told it that anything is over: its laser was switched off and on.
    bench.until_driving();
    assert_eq!(bench.lidar().connections, connections + 1);
    assert_eq!(bench.raised(Fault::LidarLost), 1);
    assert!(!bench.has(Fault::LidarLost) && !bench.has(Fault::ScanSilent));
    bench.finish();
}

/// It streams on, but what it says of itself is asked whenever it is connected.
#[test]
fn a_lidar_that_says_that_it_is_not_well_is_not_driven_by() {
    let mut bench = Bench::driving();
    disturb(&bench, Disturbance::Unwell { unwell: true });
    bench.is_stopped(NOTICED_S, |bench| bench.devices.unplug_lidar());
    bench.devices.plug_in_lidar(bench.now_ns);
    bench.stands_for(20.0);
    assert!(bench.has(Fault::LidarLost) && bench.has(Fault::ScanSilent));
    disturb(&bench, Disturbance::Unwell { unwell: false });
    bench.until_driving();
    assert!(!bench.has(Fault::LidarLost) && !bench.has(Fault::ScanSilent));
    bench.finish();
}

fn disturb(bench: &Bench, disturbance: Disturbance) {
    bench.devices.disturb_lidar(disturbance, bench.now_ns);
}

/// It shows for ever what was there.
const FROZEN: Disturbance = Disturbance::Repeat { repeats: true };

#[test]
fn a_lidar_that_freezes_while_the_robot_stands_hides_nobody() {
    let mut bench = Bench::driving();
    bench.ask(Request::Pause);
    bench.until_standing(3.0);
    let connections = bench.lidar().connections;
    disturb(&bench, FROZEN);
    let ahead = bench.ahead(0.55);
    bench.add(Shape::Box {
        pose: ahead,
        length_m: 0.2,
        width_m: 0.6,
    });
    // Its laser is switched off and on, and then it sees again.
    bench.until("connected anew", 2.0, |bench| {
        bench.lidar().connections > connections
    });
    bench.ask(Request::Resume);
    bench.stands_for(10.0);
    assert!(!bench.has(Fault::LidarFrozen));
    bench.finish();
}

#[test]
fn a_lidar_that_freezes_again_and_again_waits_for_an_operator() {
    let mut bench = Bench::driving();
    for time in 1..=3 {
        assert!(!bench.has(Fault::LidarFrozen), "{time}");
        let connections = bench.lidar().connections;
        disturb(&bench, FROZEN);
        bench.until("connected anew", 10.0, |bench| {
            bench.lidar().connections > connections
        });
        bench.watch(4.0);
    }
    assert!(bench.has(Fault::LidarFrozen));
    bench.until_standing(1.0);
    bench.stands_for(10.0);
    let (reply, _) = bench.answer_to(Request::Reset);
    assert_eq!(reply, Ok(Done::Reset(Vec::new())));
    bench.until_driving();
    bench.finish();
}

/// A second after its laser is switched on it shows what was there again, for as long as its firmware is broken.
#[test]
fn a_lidar_that_freezes_after_each_time_it_is_switched_on_keeps_the_robot_standing() {
    let mut bench = Bench::driving();
    let connections = bench.lidar().connections;
    disturb(&bench, Disturbance::RepeatAgain { repeats: true });
    bench.until_standing(3.0);
    bench.until_raised(Fault::LidarFrozen, 6.0);
    assert_eq!(bench.lidar().connections, connections + 2);
    // Who resets it before the lidar is mended has it find the same once more.
    bench.ask(Request::Reset);
    bench.stands_for(10.0);
    assert_eq!(bench.raised(Fault::LidarFrozen), 2);
    disturb(&bench, Disturbance::RepeatAgain { repeats: false });
    bench.stands_for(5.0);
    bench.ask(Request::Reset);
    bench.until_driving();
    assert!(!bench.has(Fault::LidarFrozen) && !bench.has(Fault::LidarLost));
    bench.finish();
}
