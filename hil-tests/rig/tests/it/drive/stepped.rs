//! The drive reports that something is wrong with it.

use onboard::process::ctl::Request;
use onboard::symbols::faults::Fault;
use sim::kelo::DriveHandle;

use crate::stepped::bench::Bench;

/// A fault is believed after 50 ms, so that noise stops nobody.
const BELIEVED_S: f64 = 0.05;
const OVERTEMPERATURE_1: u16 = 0x0200;

type Inject = fn(&DriveHandle);

/// What a drive reports of itself.
const REPORTED: [(Fault, Inject); 3] = [
    // Still enough for the motors, which the stop needs.
    (Fault::BusVoltage, |drive| drive.set_bus_voltage(Some(18.0))),
    (Fault::DriveFault, |drive| {
        drive.set_status1_bits(OVERTEMPERATURE_1, 0)
    }),
    (Fault::MotorsOff, |drive| drive.set_emergency_stop(true)),
];

#[test]
fn low_voltage_motor_faults_and_the_emergency_stop_hold_it_until_an_operator_agrees() {
    for (fault, inject) in REPORTED {
        let mut bench = Bench::driving();
        bench.is_stopped(BELIEVED_S, |bench| inject(bench.devices.drive_faults()));
        bench.until_raised(fault, 1.0);
        // That the cause is gone is not enough, nor is `resume`, which is no reset.
        bench.devices.drive_faults().clear_faults();
        bench.stands_for(5.0);
        bench.ask(Request::Resume);
        bench.stands_for(5.0);
        bench.ask(Request::Reset);
        bench.until_driving();
        assert!(!bench.has(fault));
        bench.finish();
    }
}

/// Whoever presses it wants the robot to stay where it is, however soon it is released.
#[test]
fn an_emergency_stop_that_is_released_at_once_holds_it_as_well() {
    for pressed_s in [0.03, 0.1, 0.19] {
        let mut bench = Bench::driving();
        bench.devices.drive_faults().set_emergency_stop(true);
        bench.watch(pressed_s);
        bench.devices.drive_faults().set_emergency_stop(false);
        bench.until_raised(Fault::MotorsOff, 0.2);
        bench.until_standing(2.0);
        bench.stands_for(5.0);
        bench.ask(Request::Reset);
        bench.until_driving();
        assert!(!bench.has(Fault::MotorsOff));
        bench.finish();
    }
}

/// It may take the voltage down with it, for less than what is noise.
#[test]
fn an_emergency_stop_that_is_released_at_once_holds_it_also_beside_noise() {
    for (fault_ms, pressed_ms) in [(5, 30), (40, 30), (40, 100), (45, 190)] {
        let mut bench = Bench::driving();
        let drive = bench.devices.drive_faults().clone();
        drive.set_emergency_stop(true);
        drive.set_bus_voltage(Some(18.0));
        let steps = f64::from(fault_ms.min(pressed_ms)) * 1e-3;
        bench.watch(steps);
        if fault_ms < pressed_ms {
            drive.set_bus_voltage(None);
            bench.watch(f64::from(pressed_ms) * 1e-3 - steps);
            drive.set_emergency_stop(false);
        } else {
            drive.set_emergency_stop(false);
            bench.watch(f64::from(fault_ms) * 1e-3 - steps);
            drive.set_bus_voltage(None);
        }
        bench.until_raised(Fault::MotorsOff, 0.2);
        assert_eq!(bench.raised(Fault::BusVoltage), 0, "{fault_ms} ms");
        bench.until_standing(2.0);
        bench.stands_for(5.0);
        bench.ask(Request::Reset);
        bench.until_driving();
        bench.finish();
    }
}

/// The stop itself is commanded, as long as the wheels obey.
#[test]
fn with_emergency_bits_a_drive_with_a_fault_has_no_power_from_its_stop_to_its_reset() {
    let emergencies = |bench: &Bench| bench.devices.drive_faults().statistics().emergency;
    for (fault, inject) in REPORTED {
        for asked in [true, false] {
            let name = fault.name();
            let mut bench = Bench::driving_with(&[
                &format!("drive.emergency_bits={asked}"),
                "drive.following_error_m=0.015",
            ]);
            inject(bench.devices.drive_faults());
            bench.until_raised(fault, 1.0);
            bench.until("it rolls no more", 2.0, |bench| {
                assert_eq!(emergencies(bench), 0, "{name}: while it rolls");
                bench.truth().twist.v_m_s.abs() < 0.01
            });
            bench.stands_for(2.0);
            assert_eq!(emergencies(&bench) > 1000, asked, "{name}");
            // A drive that has recovered is held all the same.
            bench.devices.drive_faults().clear_faults();
            bench.stands_for(1.0);
            let before = emergencies(&bench);
            bench.stands_for(1.0);
            assert_eq!(emergencies(&bench) > before, asked, "{name}: recovered");
            bench.ask(Request::Reset);
            bench.until_driving();
            let before = emergencies(&bench);
            bench.drives_for(1.0);
            assert_eq!(emergencies(&bench), before, "{name}: driving");
            bench.finish();
        }
    }
}

/// A drive whose firmware hangs answers with a healthy status.
#[test]
fn a_drive_whose_sensors_stand_still_is_not_taken_for_one_with_a_motor_fault() {
    let mut bench = Bench::driving();
    bench.devices.drive_faults().freeze_sensors(true);
    bench.until_raised(Fault::DriveStalled, 0.5);
    bench.until_standing(1.0);
    assert_eq!(bench.raised(Fault::DriveFault), 0);
    // A reset is of no use while it lasts.
    bench.ask(Request::Reset);
    bench.stands_for(3.0);
    assert!(bench.has(Fault::DriveStalled));
    bench.devices.drive_faults().freeze_sensors(false);
    bench.ask(Request::Reset);
    bench.until_driving();
    bench.finish();
}

/// Too short for a fault, and long enough to drive: the robot does not take itself for one that stood, and knows where it is.
#[test]
fn a_drive_whose_sensors_stand_still_for_a_moment_is_not_taken_for_one_that_stands() {
    let mut bench = Bench::driving();
    let stands_at = |bench: &mut Bench| {
        bench.ask(Request::Stop);
        bench.until_standing(3.0);
        bench.watch(0.5);
        let odometry = bench.kept().expect("a checkpoint").odometry;
        (odometry.pose.position(), bench.truth().pose)
    };
    let (counted_from, from) = stands_at(&mut bench);
    bench.ask(Request::Reset);
    bench.until_driving();
    for _ in 0..5 {
        bench.watch(0.5);
        bench.devices.drive_faults().freeze_sensors(true);
        bench.watch(0.15);
        bench.devices.drive_faults().freeze_sensors(false);
    }
    bench.watch(0.5);
    let (counted_to, to) = stands_at(&mut bench);
    assert_eq!(bench.raised(Fault::DriveStalled), 0);
    assert_eq!(bench.raised(Fault::EncoderImplausible), 0);
    let counted_m = counted_to.distance_m(counted_from);
    let driven_m = (to.x_m - from.x_m).hypot(to.y_m - from.y_m);
    assert!(driven_m > 0.5, "{driven_m} m");
    assert!(
        (counted_m - driven_m).abs() < 0.02,
        "{counted_m} m of {driven_m} m"
    );
    bench.finish();
}

/// Each break is too short to be told from noise, and takes its part of the brakes.
#[test]
fn a_loose_contact_of_the_emergency_stop_is_one_that_is_pressed() {
    let mut bench = Bench::driving();
    for _ in 0..6 {
        for pressed in [true, false] {
            bench.devices.drive_faults().set_emergency_stop(pressed);
            bench.watch(0.015);
        }
    }
    assert!(bench.has(Fault::MotorsOff));
    bench.until_standing(2.0);
    bench.stands_for(5.0);
    bench.ask(Request::Reset);
    bench.until_driving();
    // One break now and then is none.
    for _ in 0..5 {
        bench.devices.drive_faults().set_emergency_stop(true);
        bench.watch(0.01);
        bench.devices.drive_faults().set_emergency_stop(false);
        bench.watch(1.0);
    }
    assert!(!bench.has(Fault::MotorsOff));
    bench.finish();
}

/// Somebody presses it, plugs the lidar in, and releases it: a robot that waits for its lidar sees that as well.
#[test]
fn an_emergency_stop_beside_a_robot_that_waits_for_its_lidar_holds_it() {
    let mut bench = Bench::standing();
    bench.devices.unplug_lidar();
    bench.watch(4.0);
    bench.devices.drive_faults().set_emergency_stop(true);
    bench.watch(2.0);
    let now_ns = bench.now_ns;
    bench.devices.plug_in_lidar(now_ns);
    bench.watch(0.2);
    bench.devices.drive_faults().set_emergency_stop(false);
    bench.stands_for(10.0);
    assert!(bench.has(Fault::MotorsOff));
    bench.ask(Request::Reset);
    bench.until_driving();
    bench.finish();
}
